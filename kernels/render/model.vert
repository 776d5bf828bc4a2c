// The host puts "#version 330 core" and one of TEXTURED, VERTEX_COLORED, UNKNOWN, perhaps SHADED too, in front of
// this text.
layout(location = 0) in vec3 position;  // object frame about the bounding box's centre, metres
#ifdef TEXTURED
layout(location = 1) in vec2 texture_coordinate;
out vec2 fragment_coordinate;
#endif
#ifdef VERTEX_COLORED
layout(location = 2) in vec4 color;
out vec4 fragment_color;
#endif

uniform mat4 clip_from_object;
#ifdef SHADED
uniform mat4 camera_from_object;
out vec3 fragment_position;  // camera frame, metres
#endif

void main() {
#ifdef SHADED
  fragment_position = (camera_from_object * vec4(position, 1.0)).xyz;
#endif
  gl_Position = clip_from_object * vec4(position, 1.0);
#ifdef TEXTURED
  fragment_coordinate = texture_coordinate;
#endif
#ifdef VERTEX_COLORED
  fragment_color = color;
#endif
}
