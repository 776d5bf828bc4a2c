/* A program in C99: makes a picture card of arrays, draws it where it moves, and tracks it. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "holdfast/holdfast.h"

#define CHECK(condition)                                                                         \
  do {                                                                                           \
    if (!(condition)) {                                                                          \
      fprintf(stderr, "line %d: %s: %s\n", __LINE__, #condition, holdfast_last_error());         \
      exit(1);                                                                                   \
    }                                                                                            \
  } while (0)

enum { WIDTH = 320, HEIGHT = 240, TEXELS = 256 };

static const double HALF = 0.08; /* of the card's edge, metres */
static uint8_t texture[TEXELS][TEXELS][4];
static uint8_t frame[HEIGHT][WIDTH + 5][3]; /* rows are 5 pixels apart */

/* Blocks of many sizes in pseudo-random colours. */
static void paint_texture(void) {
  uint32_t state = 1;
  int i, x, y, c;
  memset(texture, 255, sizeof texture);
  for (i = 0; i < 400; ++i) {
    int left, top, size;
    uint8_t color[3];
    state = state * 1664525u + 1013904223u;
    left = (int)(state >> 24);
    state = state * 1664525u + 1013904223u;
    top = (int)(state >> 24);
    state = state * 1664525u + 1013904223u;
    size = 6 + (int)(state >> 27);
    for (c = 0; c < 3; ++c) color[c] = (uint8_t)(40 + ((state >> (8 * c)) & 127));
    for (y = top; y < top + size && y < TEXELS; ++y) {
      for (x = left; x < left + size && x < TEXELS; ++x) memcpy(texture[y][x], color, 3);
    }
  }
}

/* The card faces the camera (y up, so it is turned half round about x) with its centre at x, y, z. */
static void draw_frame(const holdfast_camera* camera, double x, double y, double z) {
  int u, v, i, j, c;
  for (v = 0; v < HEIGHT; ++v) {
    for (u = 0; u < WIDTH; ++u) {
      double sum[3] = {0, 0, 0};
      for (i = 0; i < 16; ++i) {
        const double px = (u + (i % 4 + 0.5) / 4 - 0.5 - camera->cx) / camera->fx * z - x;
        const double py = (v + (i / 4 + 0.5) / 4 - 0.5 - camera->cy) / camera->fy * z - y;
        const int column = (int)floor((px / HALF + 1) / 2 * TEXELS);
        const int row = (int)floor((py / HALF + 1) / 2 * TEXELS);
        const int on_card = column >= 0 && column < TEXELS && row >= 0 && row < TEXELS;
        for (c = 0; c < 3; ++c) sum[c] += on_card ? texture[row][column][c] : 120;
      }
      for (j = 0; j < 3; ++j) frame[v][u][2 - j] = (uint8_t)(sum[j] / 16 + 0.5);
    }
  }
}

static holdfast_mesh* make_card(void) {
  const float h = (float)HALF;
  const float positions[] = {-h, -h, 0, h, -h, 0, h, h, 0, -h, h, 0};
  const float uv[] = {0, 0, 1, 0, 1, 1, 0, 1};
  const uint32_t triangles[] = {0, 1, 2, 0, 2, 3};
  holdfast_mesh* mesh = NULL;
  holdfast_mesh_arrays arrays;
  arrays.positions = positions;
  arrays.vertex_count = 4;
  arrays.triangles = triangles;
  arrays.triangle_count = 2;
  arrays.texture_coordinates = uv;
  arrays.texture = &texture[0][0][0];
  arrays.texture_width = TEXELS;
  arrays.texture_height = TEXELS;
  CHECK(holdfast_mesh_create(&arrays, &mesh) == HOLDFAST_OK);
  arrays.vertex_count = 3;
  CHECK(holdfast_mesh_create(&arrays, &mesh) == HOLDFAST_MODEL);
  CHECK(strstr(holdfast_last_error(), "vertex 3") != NULL);
  return mesh;
}

/* A holdfast_camera cannot say what lens its coefficients are of. */
static void check_fisheye(holdfast_camera* loaded) {
  const char* path = "c_api_fisheye.yaml";
  FILE* file = fopen(path, "w");
  CHECK(file != NULL);
  if (file == NULL) return;
  fprintf(file, "image_width: 640\nimage_height: 480\ndistortion_model: equidistant\n"
                "camera_matrix: [600, 0, 320, 0, 600, 240, 0, 0, 1]\n"
                "distortion_coefficients: [0.1, 0.02, 0, 0]\n");
  fclose(file);
  CHECK(holdfast_camera_load(path, 0, 0, loaded) == HOLDFAST_CAMERA);
  CHECK(strstr(holdfast_last_error(), "fisheye") != NULL);
  remove(path);
}

static void check_misuse(holdfast_tracker* tracker, const holdfast_mesh* mesh, const holdfast_camera* camera,
                         holdfast_image image) {
  holdfast_result result;
  holdfast_tracker* other = NULL;
  holdfast_camera loaded;
  CHECK(holdfast_tracker_track(tracker, &image, -1, &result) == HOLDFAST_INVALID_ARGUMENT); /* before reset */
  CHECK(holdfast_tracker_track(NULL, &image, -1, &result) == HOLDFAST_INVALID_ARGUMENT);
  CHECK(strstr(holdfast_last_error(), "tracker") != NULL);
  CHECK(holdfast_tracker_create(mesh, camera, "quick", NULL, &other) == HOLDFAST_INVALID_ARGUMENT && other == NULL);
  CHECK(strstr(holdfast_last_error(), "quick") != NULL);
  CHECK(holdfast_tracker_create(mesh, camera, NULL, "no such device", &other) == HOLDFAST_DEVICE);
  CHECK(holdfast_mesh_load("no-such-file.obj", 1, NULL) == HOLDFAST_INVALID_ARGUMENT);
  CHECK(holdfast_camera_load("no-such-file.yml", 0, 0, &loaded) == HOLDFAST_FILE);
  CHECK(strstr(holdfast_last_error(), "no-such-file.yml") != NULL);
  check_fisheye(&loaded);
  holdfast_mesh_destroy(NULL);
  holdfast_tracker_destroy(NULL);
}

static void check_mask(const holdfast_tracker* tracker, const holdfast_result* result) {
  static uint8_t classes[HEIGHT * WIDTH];
  int i, used = 0;
  CHECK(holdfast_tracker_mask(tracker, classes, 5) == HOLDFAST_INVALID_ARGUMENT);
  CHECK(holdfast_tracker_mask(tracker, classes, sizeof classes) == HOLDFAST_OK);
  for (i = 0; i < HEIGHT * WIDTH; ++i) used += classes[i] == HOLDFAST_USED;
  CHECK(used > 100 && result->texture.used_pixels > 100);
}

/* The product of both is the identity, up to how far the numbers lie apart. */
static void check_inverse(const double* covariance, const double* information) {
  int row, column, k;
  for (row = 0; row < 6; ++row) {
    for (column = 0; column < 6; ++column) {
      double sum = 0, size = 1;
      for (k = 0; k < 6; ++k) {
        const double term = covariance[6 * row + k] * information[6 * k + column];
        sum += term;
        size += fabs(term);
      }
      CHECK(fabs(sum - (row == column)) < 1e-6 * size);
    }
  }
}

int main(void) {
  const holdfast_camera camera = {WIDTH, HEIGHT, 300, 300, 159.5, 119.5, {0, 0, 0, 0, 0, 0, 0, 0}};
  double pose[16] = {1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0.4, 0, 0, 0, 1};
  const holdfast_image image = {&frame[0][0][0], WIDTH, HEIGHT, sizeof frame[0], HOLDFAST_BGR8};
  holdfast_mesh* mesh;
  holdfast_tracker* tracker = NULL;
  holdfast_result result;
  int i;

  CHECK(strlen(holdfast_version()) >= 5 && holdfast_last_error()[0] == '\0');
  paint_texture();
  mesh = make_card();
  CHECK(holdfast_tracker_create(mesh, &camera, NULL, NULL, &tracker) == HOLDFAST_OK);
  check_misuse(tracker, mesh, &camera, image);
  holdfast_mesh_destroy(mesh);

  draw_frame(&camera, 0, 0, 0.4);
  CHECK(holdfast_tracker_reset(tracker, pose, &image, 0) == HOLDFAST_OK);
  for (i = 0; i < 10; ++i) {
    const double x = 0.002 * i, y = -0.001 * i, z = 0.4 + 0.002 * i;
    draw_frame(&camera, x, y, z);
    CHECK(holdfast_tracker_track(tracker, &image, (i + 1) / 30.0, &result) == HOLDFAST_OK);
    CHECK(result.held && result.message[0] == '\0');
    CHECK(fabs(result.T_camera_object[3] - x) < 0.0005);
    CHECK(fabs(result.T_camera_object[7] - y) < 0.0005);
    CHECK(fabs(result.T_camera_object[11] - z) < 0.002);
    CHECK(result.reason == HOLDFAST_REASON_NONE && result.texture.holds);
    CHECK(result.information[0] > 0 && result.milliseconds > 0);
    check_inverse(result.covariance, result.information);
  }
  CHECK(holdfast_tracker_track(tracker, &image, 0, &result) == HOLDFAST_INVALID_ARGUMENT); /* before the last */
  CHECK(holdfast_tracker_track(tracker, &image, -1, &result) == HOLDFAST_INVALID_ARGUMENT); /* times, then none */
  check_mask(tracker, &result);
  CHECK(holdfast_tracker_refine(tracker, &image, result.T_camera_object, &result) == HOLDFAST_OK && result.held);
  /* As long as nothing is known of it, contour and edges are asked beside its texture. */
  draw_frame(&camera, 0, 0, 0.4);
  CHECK(holdfast_tracker_reset(tracker, pose, NULL, -1) == HOLDFAST_OK);
  CHECK(holdfast_tracker_track(tracker, &image, -1, &result) == HOLDFAST_OK && result.held);
  CHECK(result.contour.near_lines > 0 && result.contour.near_lines <= result.contour.lines);
  CHECK(result.edges.near_lines > 0 && result.edges.near_lines <= result.edges.lines);
  CHECK(result.edges.score > 0 && result.edges.score <= 1);
  CHECK(result.edges.residual > 0 && result.edges.residual < 3);
  pose[0] = 2; /* no rotation */
  CHECK(holdfast_tracker_reset(tracker, pose, NULL, -1) == HOLDFAST_POSE);
  holdfast_tracker_destroy(tracker);
  return 0;
}
