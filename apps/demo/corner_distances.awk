# awk -f corner_distances.awk camera.yml corners.csv poses.csv: how far the tracked box's corners are, in pixels, from
# where they were marked by hand. A frame that is not held counts as infinitely far. Fails beyond 10 px, 4 px median.
BEGIN { FS = ","; largest_allowed = 10; median_allowed = 4 }

FNR == 1 { ++file }

# The first matrix of the calibration, row by row: fx 0 cx 0 fy cy 0 0 1. It may go over several lines.
file == 1 && !read_camera {
  if (/data:/) inside = 1
  if (inside) text = text " " $0
  if (inside && /\]/) {
    gsub(/.*\[|\].*|,/, " ", text)
    split(text, K, " ")
    read_camera = 1
  }
}

file == 2 && /^[0-9]/ {
  ++marks[$1]
  for (i = 2; i <= 6; ++i) mark[$1, marks[$1], i] = $i
}

# frame,time_s,status,tx,ty,tz,qx,qy,qz,qw,...
file == 3 && ($1 in marks) && $3 == "held" {
  for (n = 1; n <= marks[$1]; ++n) {
    x = mark[$1, n, 2]; y = mark[$1, n, 3]; z = mark[$1, n, 4]
    a = $7; b = $8; c = $9; w = $10
    px = (1 - 2 * (b * b + c * c)) * x + 2 * (a * b - c * w) * y + 2 * (a * c + b * w) * z + $4
    py = 2 * (a * b + c * w) * x + (1 - 2 * (a * a + c * c)) * y + 2 * (b * c - a * w) * z + $5
    pz = 2 * (a * c - b * w) * x + 2 * (b * c + a * w) * y + (1 - 2 * (a * a + b * b)) * z + $6
    du = K[1] * px / pz + K[3] - mark[$1, n, 5]
    dv = K[5] * py / pz + K[6] - mark[$1, n, 6]
    distance[++count] = sqrt(du * du + dv * dv)
  }
  seen[$1] = 1
}

END {
  for (frame in marks) {
    ++frames
    if (!(frame in seen)) {
      for (n = 1; n <= marks[frame]; ++n) distance[++count] = 1e9
      missing = missing " " frame
    }
  }
  if (!read_camera || count == 0) {
    print "Corners: nothing to compare"
    exit 1
  }
  for (i = 2; i <= count; ++i) {
    value = distance[i]
    for (j = i - 1; j >= 1 && distance[j] > value; --j) distance[j + 1] = distance[j]
    distance[j + 1] = value
  }
  median = (distance[int((count + 1) / 2)] + distance[int(count / 2) + 1]) / 2
  if (missing != "") printf "Corners: not held in the marked frames%s\n", missing
  printf "Against %d corners marked by hand in %d frames: median %.1f px off, largest %.1f px (allowed: %g and %g)\n",
    count, frames, median, distance[count], median_allowed, largest_allowed
  exit median <= median_allowed && distance[count] <= largest_allowed ? 0 : 1
}
