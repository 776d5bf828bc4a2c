// The host puts "#version 330 core" and one of TEXTURED (perhaps SUPERSAMPLED too), VERTEX_COLORED, UNKNOWN in front of
// this text, and SHADED where light falls on the surface: llvmpipe takes both sides of every branch, so that a uniform
// would make all pixels pay for what few need.
#ifdef TEXTURED
in vec2 fragment_coordinate;
uniform sampler2D surface;
#endif
#ifdef VERTEX_COLORED
in vec4 fragment_color;
#endif

#ifdef SHADED
in vec3 fragment_position;
uniform vec3 shading;  // how much brighter surface that faces this way (camera frame) looks than its texture
#endif

out vec4 pixel;

void main() {
#if defined(SUPERSAMPLED)
  // Four samples a pixel, averaged as light (nearly the square of what is encoded), as a camera's pixel does it: two by
  // two of half a pixel each; on a slanted surface four in a row, or it would be blurred across its slant.
  vec2 across = dFdx(fragment_coordinate), down = dFdy(fragment_coordinate), texels = vec2(textureSize(surface, 0));
  vec2 texels_across = across * texels, texels_down = down * texels;
  float across2 = dot(texels_across, texels_across), down2 = dot(texels_down, texels_down);
  vec2 longer = across2 > down2 ? across : down, shorter = across2 > down2 ? down : across;
  bool slanted = max(across2, down2) > max(1.0, 4.0 * min(across2, down2));
  vec2 step1 = 0.25 * longer, step2 = slanted ? 0.125 * longer : 0.25 * shorter;
  // Found once: as part of every sample it takes a sixth of the time.
  float level = 0.5 * log2(max(across2, down2)) + (slanted ? -2.0 : -1.0);
  vec4 a = textureLod(surface, fragment_coordinate - step1 - step2, level);
  vec4 b = textureLod(surface, fragment_coordinate - step1 + step2, level);
  vec4 c = textureLod(surface, fragment_coordinate + step1 - step2, level);
  vec4 d = textureLod(surface, fragment_coordinate + step1 + step2, level);
  vec4 color = vec4(sqrt(0.25 * (a.rgb * a.rgb + b.rgb * b.rgb + c.rgb * c.rgb + d.rgb * d.rgb)),
                    0.25 * (a.a + b.a + c.a + d.a));
#elif defined(TEXTURED)
  // Texels of half a pixel, between which bilinear filtering averages over about one; those of a whole pixel would
  // blur over two and put edges elsewhere.
  vec4 color = texture(surface, fragment_coordinate, -1.0);
#elif defined(VERTEX_COLORED)
  vec4 color = fragment_color;
#else
  vec4 color = vec4(0.0);
#endif
#ifdef SHADED
  vec3 normal = normalize(cross(dFdx(fragment_position), dFdy(fragment_position)));
  normal *= -sign(dot(normal, fragment_position));
  color.rgb *= (1.0 + dot(shading, normal)) / (1.0 + length(shading));
#endif
  // Filtering mixes never-seen texels (alpha 0) in; where that is more than a trace, the colour is not known. As
  // kKnownAlpha.
  pixel = vec4(color.rgb, step(0.98, color.a));
}
