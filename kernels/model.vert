// The host puts "#version 330 core" and one of TEXTURED, VERTEX_COLORED, UNKNOWN, perhaps SHADED and TONED too, in front
// of this text.
layout(location = 0) in vec3 position;  // object frame about the bounding box's centre, metres
#ifdef TEXTURED
layout(location = 1) in vec2 texture_coordinate;
out vec2 fragment_coordinate;
#endif
#ifdef VERTEX_COLORED
layout(location = 2) in vec4 color;
out vec4 fragment_color;
#endif

#ifdef SHADED
layout(location = 3) in vec3 normal;  // towards the triangle's front
uniform vec3 shading;  // object frame: how much brighter than evenly lit surface is that faces this way
out float fragment_shading;
#endif

uniform mat4 clip_from_object;

void main() {
  gl_Position = clip_from_object * vec4(position, 1.0);
#ifdef TEXTURED
  fragment_coordinate = texture_coordinate;
#endif
#ifdef VERTEX_COLORED
  fragment_color = color;
#endif
#ifdef SHADED
  fragment_shading = dot(shading, normal);
#endif
}
