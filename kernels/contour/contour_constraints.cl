/* Lines across the object's contour: where along each of them the frame's colours change from the object's to the
   background's (equations 23 to 28 of docs/math.md). A work-item a line, whatever the partition: lines are few. */

/* Colours are told apart by their highest bits. */
INLINE int color_bin(float4 pixel) {
  const int most = (1 << HF_COLOR_BITS) - 1;
  const int4 c = clamp(convert_int4(pixel * (float)(1 << HF_COLOR_BITS)), (int4)(0), (int4)(most));
  return ((c.x << HF_COLOR_BITS | c.y) << HF_COLOR_BITS) | c.z;
}

typedef struct {
  float3 p;              /* point of the contour, camera axes, metres */
  float2 pixel;          /* where it is seen */
  float2 normal;         /* out of the object, unit length */
  float inside, outside; /* how far the object and the background reach along it, pixels */
} contour_line;

/* A point of the view's contour where D moves it. */
INLINE contour_line moved_line(__global const float* points, int i, hf_contour o) {
  const float8 point = vload8(i, points);
  contour_line line;
  line.p = (float3)(o.d[0] * point.s0 + o.d[1] * point.s1 + o.d[2] * point.s2 + o.d[3],
                    o.d[4] * point.s0 + o.d[5] * point.s1 + o.d[6] * point.s2 + o.d[7],
                    o.d[8] * point.s0 + o.d[9] * point.s1 + o.d[10] * point.s2 + o.d[11]);
  const float2 normal = (float2)(o.d[0] * point.s3 + o.d[1] * point.s4, o.d[4] * point.s3 + o.d[5] * point.s4);
  line.normal = normal / fmax(length(normal), 1e-6f);
  const float z = fmax(line.p.z, HF_CONTOUR_LEAST_Z);
  line.pixel = (float2)(o.fx * line.p.x / z + o.cx, o.fy * line.p.y / z + o.cy);
  line.inside = point.s5;
  line.outside = point.s6;
  return line;
}

/* The pixel of the frame k steps along a line and how far its centre is beyond the contour; false where there is none.
 */
INLINE int line_pixel(__global const float* frame, hf_layout layout, hf_contour o, contour_line line, int k,
                      float4* pixel, float* beyond) {
  const float2 at = rint(line.pixel + (float)k * line.normal);
  const int x = (int)at.x, y = (int)at.y;
  if (!(x >= o.region.x && y >= o.region.y && x < o.region.x + o.region.width && y < o.region.y + o.region.height))
    return 0;
  *beyond = dot(at - line.pixel, line.normal);
  *pixel = vload4(element(layout, x, y), frame);
  return pixel->w > 0.99f && *beyond >= -line.inside && *beyond <= line.outside;
}

/* Bins of the colours along the lines, 2 reach + 1 of them a line from the inside out; -1: none. */
__kernel void contour_colors(__global const float* frame, hf_layout layout, __global const float* points, hf_contour o,
                             __global int* bins) {
  const int i = (int)get_global_id(0);
  if (i >= o.count) return;
  const contour_line line = moved_line(points, i, o);
  __global int* out = bins + i * (2 * o.reach + 1) + o.reach;
  for (int k = -o.reach; k <= o.reach; ++k) {
    float4 pixel;
    float beyond;
    const int there = line.p.z >= HF_CONTOUR_LEAST_Z && line_pixel(frame, layout, o, line, k, &pixel, &beyond);
    out[k] = there ? color_bin(pixel) : -1;
  }
}

INLINE float total(float16 v) {
  const float8 a = v.lo + v.hi;
  const float4 b = a.lo + a.hi;
  return b.x + b.y + b.z + b.w;
}

/* Mean colour and variance of one side of the contour (side 1: outside, -1: inside), from pixels that look like those
   nearer to it: what lies farther may be of another colour. False where too little of it is seen. */
INLINE int side_colors(__global const float* frame, hf_layout layout, hf_contour o, contour_line line, int side,
                       float3* mean, float* variance) {
  float3 nearest = (float3)(0.0f), sum = (float3)(0.0f); /* the sum is of differences: small ones stay exact */
  float squares = 0.0f, weights = 0.0f;
  int count = 0;
  for (int k = o.beside; k <= o.around; ++k) {
    float4 pixel;
    float beyond;
    if (!line_pixel(frame, layout, o, line, side * k, &pixel, &beyond)) continue;
    if (count++ == 0) nearest = pixel.xyz;
    const float3 from_nearest = pixel.xyz - nearest;
    const float3 other = from_nearest - sum / fmax(weights, 1.0f);
    const float weight = 1.0f / (1.0f + dot(other, other) / HF_CONTOUR_ALIKE2);
    sum += weight * from_nearest;
    squares += weight * dot(from_nearest, from_nearest);
    weights += weight;
  }
  if (count < 2) return 0;
  sum /= weights;
  *mean = nearest + sum;
  *variance = fmax(0.0f, squares / weights - dot(sum, sum));
  return 1;
}

/* How far beyond the contour the shares put the edge that both sides' colours have in the pixels next to it, as an
   area: no symmetrical blur moves it (equation 27). `doubt` is what the colours vary by, over their squared contrast;
   false where too little of a side is seen. */
INLINE int edge_by_shares(__global const float* frame, hf_layout layout, hf_contour o, contour_line line, float* offset,
                          float* doubt) {
  float3 inside, outside;
  float inside_variance, outside_variance;
  if (!side_colors(frame, layout, o, line, -1, &inside, &inside_variance) ||
      !side_colors(frame, layout, o, line, 1, &outside, &outside_variance))
    return 0;
  const float3 difference = inside - outside;
  const float contrast2 = fmax(dot(difference, difference), 1e-6f);
  *doubt = (inside_variance + outside_variance + HF_CONTOUR_NOISE2) / contrast2;
  float sum = 0.0f;
  for (int k = -o.beside; k <= o.beside; ++k) {
    float4 pixel;
    float beyond;
    if (!line_pixel(frame, layout, o, line, k, &pixel, &beyond)) continue;
    const float share = clamp(dot(pixel.xyz - outside, difference) / contrast2, -0.5f, 1.5f);
    const float expected = 0.5f - 0.5f * clamp(beyond / HF_CONTOUR_HALF_EDGE, -1.0f, 1.0f);
    const float t = beyond / (o.beside + 0.5f);
    sum += fmax(0.0f, 1.0f - t * t) * (share - expected);
  }
  *offset = sum;
  return 1;
}

/* Likelihood of sixteen places of the edge along each line, its mean and variance, and the row and sums they make. */
__kernel void contour_constraints(__global const float* frame, hf_layout layout, __global const float* points,
                                  hf_contour o, __global const float* object_share, __global float* sums) {
  const int i = (int)get_global_id(0);
  if (i >= o.count) return;
  __global float* out = sums + i * HF_CONTOUR_SUMS;
  for (int n = 0; n < HF_CONTOUR_SUMS; ++n) out[n] = 0.0f;
  const contour_line line = moved_line(points, i, o);
  if (line.p.z < HF_CONTOUR_LEAST_Z) return;

  const float16 place = ((float16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15) - 7.5f) * o.step;
  float16 likelihood = (float16)(1.0f);
  float agreement = 0.0f, pixels = 0.0f;
  for (int k = -o.reach; k <= o.reach; ++k) {
    float4 pixel;
    float beyond;
    if (!line_pixel(frame, layout, o, line, k, &pixel, &beyond)) continue;
    const float contrast = 2.0f * object_share[color_bin(pixel)] - 1.0f;
    const float16 x = beyond - place;
    likelihood *= 0.5f - o.trust * contrast * (x * rsqrt(x * x + o.softness2));
    const float side = beyond * rsqrt(beyond * beyond + o.softness2);
    agreement -= contrast * side;
    pixels += fabs(side);
  }
  if (pixels < HF_CONTOUR_LEAST_PIXELS) return;
  const float all = total(likelihood);
  float distance = total(likelihood * place) / all;
  const float variance = total(likelihood * (place - distance) * (place - distance)) / all;
  /* Sixteen places that are all as likely tell nothing. */
  const float flat = (256.0f - 1.0f) / 12.0f * o.step * o.step;
  const float information = fmax(0.0f, 1.0f / (variance + o.variance) - 1.0f / (flat + o.variance));
  float weight = information;
  if (o.by_shares) {
    const float by_colors = distance;
    float doubt;
    if (!edge_by_shares(frame, layout, o, line, &distance, &doubt))
      distance = weight = 0.0f;
    else {
      const float trust = 1.0f / (1.0f + doubt / HF_CONTOUR_DOUBT);
      distance = trust * distance + (1.0f - trust) * by_colors;
      weight /= (1.0f + by_colors * by_colors / HF_CONTOUR_AGREED2) * (HF_CONTOUR_LEAST_DOUBT + doubt);
    }
  }
  if (o.far2 > 0.0f) weight /= 1.0f + distance * distance / o.far2;

  /* d(distance along the normal) / d(conditioned twist): equation 28. */
  const float z = line.p.z;
  const float gx = line.normal.x * o.fx / z, gy = line.normal.y * o.fy / z;
  const float gz = -(gx * line.p.x + gy * line.p.y) / z;
  const float8 point = vload8(i, points);
  const float3 arm = (float3)(point.s0 - o.center[0], point.s1 - o.center[1], point.s2 - o.center[2]);
  const float3 g = (float3)(o.d[0] * gx + o.d[4] * gy + o.d[8] * gz, o.d[1] * gx + o.d[5] * gy + o.d[9] * gz,
                            o.d[2] * gx + o.d[6] * gy + o.d[10] * gz);
  const float3 turn = (float3)(arm.y * g.z - arm.z * g.y, arm.z * g.x - arm.x * g.z, arm.x * g.y - arm.y * g.x);
  const float row[6] = {o.radius * g.x, o.radius * g.y, o.radius * g.z, turn.x, turn.y, turn.z};
  int n = HF_SUM_A;
  for (int a = 0; a < 6; ++a) {
    for (int b = a; b < 6; ++b) out[n++] = weight * row[a] * row[b];
    out[HF_SUM_H + a] = weight * row[a] * distance;
    out[HF_CONTOUR_OUTWARD + a] = weight * row[a];
  }
  out[HF_CONTOUR_WRR] = weight * distance * distance;
  out[HF_CONTOUR_W] = weight;
  out[HF_CONTOUR_DISTANCE] = distance;
  out[HF_CONTOUR_INFORMATION] = information;
  out[HF_CONTOUR_AGREEMENT] = agreement / pixels;
}
