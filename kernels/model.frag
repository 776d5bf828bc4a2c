// The host puts "#version 330 core" and one of TEXTURED, VERTEX_COLORED, UNKNOWN in front of this text.
#ifdef TEXTURED
in vec2 fragment_coordinate;
uniform sampler2D surface;
#endif
#ifdef VERTEX_COLORED
in vec4 fragment_color;
#endif

out vec4 pixel;

void main() {
#if defined(TEXTURED)
  vec4 color = texture(surface, fragment_coordinate);
#elif defined(VERTEX_COLORED)
  vec4 color = fragment_color;
#else
  vec4 color = vec4(0.0);
#endif
  // Filtering mixes never-seen texels (alpha 0) in; where that is more than a trace, the colour is not known.
  pixel = vec4(color.rgb, step(0.98, color.a));
}
