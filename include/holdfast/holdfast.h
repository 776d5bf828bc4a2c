#ifndef HOLDFAST_HOLDFAST_H
#define HOLDFAST_HOLDFAST_H

/**
 * Holdfast in C99: libholdfast_c. Units are metres, radians, pixels and seconds; matrices are row by row.
 *
 * Functions that return a code return HOLDFAST_OK or say in holdfast_last_error() what is wrong. Null pointers where a
 * pointer is wanted are HOLDFAST_INVALID_ARGUMENT. Handles may be used from any thread, one at a time. See
 * tests/c/test_c_api.c for a program.
 */

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define HOLDFAST_C_EXPORT __attribute__((visibility("default")))
#else
#define HOLDFAST_C_EXPORT
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** What kind of thing is wrong. */
typedef enum holdfast_code {
  HOLDFAST_OK = 0,
  HOLDFAST_INVALID_ARGUMENT = 1, /**< a value is out of its range */
  HOLDFAST_MODEL = 2,            /**< a mesh or its texture cannot be used */
  HOLDFAST_CAMERA = 3,           /**< a camera's parameters cannot be used */
  HOLDFAST_POSE = 4,             /**< a pose is no rigid motion, or puts the object where it cannot be seen */
  HOLDFAST_IMAGE = 5,            /**< a frame has the wrong size, format or memory */
  HOLDFAST_DEVICE = 6,           /**< there is no OpenCL device, or a call to it failed */
  HOLDFAST_RENDERER = 7,         /**< OpenGL (OSMesa, EGL) cannot be loaded or does not render */
  HOLDFAST_FILE = 8,             /**< an input file is missing or cannot be read */
  HOLDFAST_OUTPUT = 9,           /**< a file cannot be written */
  HOLDFAST_UNEXPECTED = 10       /**< a defect, or no memory */
} holdfast_code;

/** Byte layouts of frames. */
typedef enum holdfast_format {
  HOLDFAST_BGR8 = 0,  /**< 3 bytes a pixel */
  HOLDFAST_RGB8 = 1,  /**< 3 bytes a pixel */
  HOLDFAST_RGBA8 = 2, /**< 4 bytes a pixel, alpha ignored */
  HOLDFAST_GREY8 = 3, /**< 1 byte a pixel */
  HOLDFAST_NV12 = 4,  /**< a plane of Y, then one of U and V at half the size */
  HOLDFAST_YUYV = 5,  /**< 2 bytes a pixel */
  HOLDFAST_BGRA8 = 6  /**< 4 bytes a pixel, alpha ignored */
} holdfast_format;

/** What became of a pixel: values of holdfast_tracker_mask(). */
typedef enum holdfast_pixel_class {
  HOLDFAST_NOT_VISIBLE = 0,        /**< the object does not cover it */
  HOLDFAST_UNUSABLE = 1,           /**< covered, but of unknown texture, at the silhouette or outside the frame */
  HOLDFAST_NO_GRADIENT = 2,        /**< too little gradient in the rendered view or the frame */
  HOLDFAST_REJECTED_ANGLE = 3,     /**< gradients point apart */
  HOLDFAST_REJECTED_MAGNITUDE = 4, /**< gradients differ too much */
  HOLDFAST_REJECTED_VOTE = 5,      /**< passed, but most of its neighbourhood did not */
  HOLDFAST_USED = 6                /**< decided the pose */
} holdfast_pixel_class;

/** Why an object is lost, or hard to hold; HOLDFAST_REASON_NONE: all is well. */
typedef enum holdfast_reason {
  HOLDFAST_REASON_NONE = 0,
  HOLDFAST_REASON_OUT_OF_VIEW = 1,      /**< it is not in the picture, or not found in it */
  HOLDFAST_REASON_OCCLUDED = 2,         /**< something hides most of it */
  HOLDFAST_REASON_TOO_FAST = 3,         /**< it moves faster than can be followed, or is blurred by it */
  HOLDFAST_REASON_NO_EVIDENCE = 4,      /**< neither texture nor a contour that stands out */
  HOLDFAST_REASON_LOW_EVIDENCE = 5,     /**< less agrees than should, and nothing seen in front explains it */
  HOLDFAST_REASON_AMBIGUOUS = 6,        /**< another pose fits as well, or a turn does not show */
  HOLDFAST_REASON_NOT_SURELY_FOUND = 7, /**< lost before, and not surely found again */
  HOLDFAST_REASON_LIGHT_CHANGED = 8
} holdfast_reason;

/** Pinhole camera; axes x right, y down, z forward; pixel centres at integers. */
typedef struct holdfast_camera {
  int32_t width;        /**< pixels */
  int32_t height;       /**< pixels */
  double fx;            /**< focal length, pixels */
  double fy;            /**< focal length, pixels */
  double cx;            /**< principal point, pixels */
  double cy;            /**< principal point, pixels */
  double distortion[8]; /**< OpenCV's k1 k2 p1 p2 k3 k4 k5 k6; all zero: none */
} holdfast_camera;

/** A frame in the caller's memory, read only during the call that it is passed to. */
typedef struct holdfast_image {
  const uint8_t* data;
  int32_t width;       /**< pixels */
  int32_t height;      /**< pixels */
  size_t stride_bytes; /**< bytes from a row to the next; 0: rows are packed */
  holdfast_format format;
} holdfast_image;

/** A triangle mesh in the caller's memory, read only during the call that it is passed to. */
typedef struct holdfast_mesh_arrays {
  const float* positions; /**< 3 a vertex, metres */
  size_t vertex_count;
  const uint32_t* triangles; /**< 3 vertex indices each */
  size_t triangle_count;
  const float* texture_coordinates; /**< 2 a vertex, v upwards; null: none */
  const uint8_t* texture;           /**< RGBA, rows from the top (v = 1) down; null: none */
  int32_t texture_width;            /**< texels */
  int32_t texture_height;           /**< texels */
} holdfast_mesh_arrays;

/** What the texture said of the pose. */
typedef struct holdfast_texture_evidence {
  int32_t holds;           /**< not 0: enough alone to hold the object */
  int32_t gradient_pixels; /**< looked at, with a gradient in the rendered view */
  int32_t used_pixels;     /**< of these, those that decided the pose */
  double residual;         /**< root of the weighted mean squared residual, intensity in [0, 1] */
  double correlation;      /**< of the rendered view and the frame, [-1, 1] */
} holdfast_texture_evidence;

/** What the contour said of the pose. */
typedef struct holdfast_contour_evidence {
  int32_t holds;      /**< not 0: enough to hold the object, with the edges and without the texture */
  int32_t lines;      /**< across the contour, inside the frame */
  int32_t near_lines; /**< of these, with the edge next to the contour */
  double agreement;   /**< of colours with the contour over the near lines, [-1, 1] */
  double residual;    /**< root of the weighted mean squared distance of the edges, pixels */
} holdfast_contour_evidence;

/** What the model's edges (creases, borders) said of the pose. */
typedef struct holdfast_edge_evidence {
  int32_t lines;      /**< across edges of the model, inside the frame */
  int32_t near_lines; /**< of these, with the frame's edge next to the model's */
  double score;       /**< share of near lines beyond what chance makes, at most 1 */
  double residual;    /**< root of the weighted mean squared distance of the frame's edges, pixels */
} holdfast_edge_evidence;

/** Pixels of a model without appearance, compared with an earlier frame's. */
typedef struct holdfast_snapshot_evidence {
  int32_t holds;           /**< not 0: enough to hold the object */
  int32_t gradient_pixels; /**< of those looked at, with a gradient in the earlier frame; 0: nothing to compare with */
  int32_t used_pixels;     /**< of these, those that agree */
  double correlation;      /**< of both frames over these, [-1, 1] */
} holdfast_snapshot_evidence;

/** Where the object is in a frame, and how sure that is. */
typedef struct holdfast_result {
  double T_camera_object[16]; /**< 4x4: maps points of the object's frame to the camera's; a guess when it is lost */
  int32_t held;               /**< 0: the object is lost */
  int32_t visible_pixels;     /**< of the frame that the object covers */
  holdfast_texture_evidence texture;
  holdfast_contour_evidence contour;
  holdfast_edge_evidence edges;
  holdfast_snapshot_evidence snapshot;
  double covariance[36];  /**< 6x6, of (v, w) in T_true = T exp((v, w)): object axes; zero where nothing tells it */
  double information[36]; /**< its inverse; zero where nothing tells the pose */
  double milliseconds;    /**< that the frame took */
  holdfast_reason reason; /**< why the object is lost or hard to hold */
  char message[256];      /**< the same in words; "" when all is well */
} holdfast_result;

typedef struct holdfast_mesh holdfast_mesh;       /**< a model */
typedef struct holdfast_tracker holdfast_tracker; /**< follows one object through the frames of one camera */

/** Version of the library, for example "0.1.0". */
HOLDFAST_C_EXPORT const char* holdfast_version(void);

/** What the last function of this thread that returned another code than HOLDFAST_OK said; "" before any did. */
HOLDFAST_C_EXPORT const char* holdfast_last_error(void);

/** Reads a calibration of OpenCV, ROS or Kalibr, or a text "fx fy cx cy", for frames of this size (0, 0: the file's).
 *  That of a fisheye lens is refused (HOLDFAST_CAMERA): a holdfast_camera does not say what lens it is of. */
HOLDFAST_C_EXPORT holdfast_code holdfast_camera_load(const char* path, int32_t width, int32_t height,
                                                     holdfast_camera* camera);

/** Reads the first pose of a file: a 3x4 or 4x4 matrix, TUM, or OpenCV's rvec and tvec. */
HOLDFAST_C_EXPORT holdfast_code holdfast_pose_load(const char* path, double T_camera_object[16]);

/** Reads a model: OBJ, PLY, glTF, ...; `scale` turns its unit into metres. */
HOLDFAST_C_EXPORT holdfast_code holdfast_mesh_load(const char* path, double scale, holdfast_mesh** mesh);

/** Copies a model from arrays. */
HOLDFAST_C_EXPORT holdfast_code holdfast_mesh_create(const holdfast_mesh_arrays* arrays, holdfast_mesh** mesh);

/** Null is allowed. Trackers that were made of the mesh stay. */
HOLDFAST_C_EXPORT void holdfast_mesh_destroy(holdfast_mesh* mesh);

/**
 * Makes a tracker; compiles kernels the first time on a machine, which takes half a minute.
 * mode: "default", "fast" or "paper"; null: default. device: "cpu", "gpu", "P:D" or a part of a name; null:
 * HOLDFAST_DEVICE, else a CPU.
 */
HOLDFAST_C_EXPORT holdfast_code holdfast_tracker_create(const holdfast_mesh* mesh, const holdfast_camera* camera,
                                                        const char* mode, const char* device,
                                                        holdfast_tracker** tracker);

/** Null is allowed. */
HOLDFAST_C_EXPORT void holdfast_tracker_destroy(holdfast_tracker* tracker);

/**
 * Sets the pose that the next frame starts from, at rest. frame: the one that this is the pose in; null: none. time_s:
 * of that frame, as in holdfast_tracker_track().
 */
HOLDFAST_C_EXPORT holdfast_code holdfast_tracker_reset(holdfast_tracker* tracker, const double T_camera_object[16],
                                                       const holdfast_image* frame, double time_s);

/**
 * Finds the object in the next frame. time_s: of the frame, seconds, later than the one before; negative: frames come
 * evenly. All frames after a reset have a time, or none has.
 */
HOLDFAST_C_EXPORT holdfast_code holdfast_tracker_track(holdfast_tracker* tracker, const holdfast_image* frame,
                                                       double time_s, holdfast_result* result);

/** As holdfast_tracker_track() from this pose, without prediction; the next frame is tracked as if it had not been. */
HOLDFAST_C_EXPORT holdfast_code holdfast_tracker_refine(holdfast_tracker* tracker, const holdfast_image* frame,
                                                        const double T_camera_object[16], holdfast_result* result);

/** A holdfast_pixel_class for each pixel of the last frame, rows packed. size: bytes of `classes`, width x height. */
HOLDFAST_C_EXPORT holdfast_code holdfast_tracker_mask(const holdfast_tracker* tracker, uint8_t* classes, size_t size);

#ifdef __cplusplus
}
#endif

#endif
