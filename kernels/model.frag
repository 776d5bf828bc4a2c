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
  // Four samples a pixel, averaged as light (nearly the square of what is encoded), as a camera's pixel does it.
  vec2 across = 0.5 * dFdx(fragment_coordinate), down = 0.5 * dFdy(fragment_coordinate);
  vec2 first = fragment_coordinate - 0.5 * (across + down);
  vec4 a = texture(surface, first, -1.0), b = texture(surface, first + across, -1.0);
  vec4 c = texture(surface, first + down, -1.0), d = texture(surface, first + across + down, -1.0);
  vec4 color = vec4(sqrt(0.25 * (a.rgb * a.rgb + b.rgb * b.rgb + c.rgb * c.rgb + d.rgb * d.rgb)),
                    0.25 * (a.a + b.a + c.a + d.a));
#elif defined(VERTEX_COLORED)
  vec4 color = fragment_color;
#else
  vec4 color = vec4(0.0);
#endif
  // Filtering mixes never-seen texels (alpha 0) in; where that is more than a trace, the colour is not known.
  pixel = vec4(color.rgb, step(0.98, color.a));
}
