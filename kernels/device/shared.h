/* Constants and parameter structs that host (C++) and device (OpenCL C) share. Only 4-byte fields: the layouts agree.
 */
#ifndef HOLDFAST_SHARED_H
#define HOLDFAST_SHARED_H

#define HF_TILE 16          /* pixels a side of a tile: the unit of work and of partial sums */
#define HF_CELL 8           /* pixels a side of a cell: the unit of local photometry; 2x2 a tile */
#define HF_PAD 16           /* never-written (zero) pixels around every level image */
#define HF_CHANNELS 3       /* colour channels; a grey frame uses the first only */
#define HF_PIXEL 4          /* floats of a filtered pixel: three channels and coverage */
#define HF_SAMPLES 3        /* planes of warped samples: three channels */
#define HF_VOTE_RADIUS 4    /* of the largest neighbourhood: 9x9 */
#define HF_BLUR_RADIUS 3    /* pixels that the Gaussian of all images reaches */
#define HF_BLUR_COLUMNS 128 /* most pixels of the block that an item of the 'strips' partition blurs */
#define HF_BLUR_ROWS 32
#define HF_LEAST_COVERAGE 0.45f /* of a sample of the frame: a corner pixel has 0.49 */
#define HF_GROUP 64             /* work-items of a tile's group in the 'groups' partition */

#define HF_MOST_TAPS 24    /* moments of an exposure, at most */
#define HF_RENDER_GUARD 32 /* pixels before and behind a packed render that may be read */

/* Formats of a frame that are blurred as they come: as holdfast::PixelFormat. */
#define HF_BGR8 0
#define HF_RGB8 1
#define HF_RGBA8 2
#define HF_GREY8 3

/* Pixel classes: as holdfast::PixelClass. */
#define HF_NOT_VISIBLE 0
#define HF_UNUSABLE 1
#define HF_NO_GRADIENT 2
#define HF_REJECTED_ANGLE 3
#define HF_REJECTED_MAGNITUDE 4
#define HF_REJECTED_VOTE 5
#define HF_USED 6
/* Added to a class: the rendered view has a gradient here, so the pixel counts in its neighbours' vote. */
#define HF_COUNTS_IN_VOTE 16

/* Sums of one tile, in this order. */
#define HF_SUM_A 0        /* 21: upper triangle of A, row by row */
#define HF_SUM_H 21       /* 6 */
#define HF_SUM_WRR 27     /* sum of w r^2 */
#define HF_SUM_W 28       /* sum of w */
#define HF_SUM_ROWS 29    /* rows that entered */
#define HF_SUM_VISIBLE 30 /* pixel counts */
#define HF_SUM_USABLE 31
#define HF_SUM_GRADIENT 32
#define HF_SUM_PASSED 33
#define HF_SUM_USED 34
#define HF_SUM_MAIN 35 /* sums of the whole tile end here */
/* Sums of a cell: twelve a channel, then pixels and their depth. */
#define HF_PHOTO 12 /* w, wV, wI, wVV, wII, wVI, wr, wVr, w dx, w dy, wV dx, wV dy */
#define HF_CELL_PIXELS 36
#define HF_CELL_DEPTH 37
#define HF_CELL_SUMS 38
#define HF_SUM_PHOTO 35   /* cells 00, 01, 10, 11 (row, column) */
#define HF_SUM_STRIDE 192 /* floats from a tile's sums to the next, whole vectors; 35 + 4 * 38 used */

/* A cell's pairs: gain of three channels, bias of three channels. */
#define HF_CELL_PAIRS 8

/* Lines across the contour of an object: floats of a point, bits of each channel that tell colours apart, sums of a
   line (A and h as those of a tile, then these). */
#define HF_CONTOUR_POINT 8 /* point (camera axes), normal (x, y), reach of the object and of the background, 0 */
#define HF_COLOR_BITS 4
#define HF_CONTOUR_WRR 27 /* w times the squared distance to the edge that was found */
#define HF_CONTOUR_W 28
#define HF_CONTOUR_DISTANCE 29    /* that distance, pixels out of the object */
#define HF_CONTOUR_INFORMATION 30 /* of the line, 1 / square pixels; 0: it tells nothing */
#define HF_CONTOUR_AGREEMENT 31   /* how well its colours agree with an edge right here, -1 to 1 */
#define HF_CONTOUR_OUTWARD 32     /* 6: what h gains where every edge is found a pixel farther out */
#define HF_CONTOUR_SUMS 40
#define HF_CONTOUR_LEAST_Z 1e-6f     /* metres, of a point in front of the camera */
#define HF_CONTOUR_LEAST_PIXELS 3.0f /* of a line on the frame, else it is none */
#define HF_CONTOUR_NOISE2 2e-4f      /* variance that colours have anyway, all channels */
#define HF_CONTOUR_ALIKE2 2.5e-3f    /* squared difference from colours nearer to the contour that halves a weight */
#define HF_CONTOUR_HALF_EDGE 0.7f    /* pixels beyond the contour to which pixels show shares, sharp frames */
#define HF_CONTOUR_AGREED2 2.25f     /* squared distance of an edge by colours at which its shares weigh half */
#define HF_CONTOUR_DOUBT 0.15f       /* doubt at which an edge by shares counts as much as one by colours */
#define HF_CONTOUR_LEAST_DOUBT 0.3f  /* added to the doubt that weighs shares */

/* Lines across the edges of a model: floats of a line, pixels looked at on either side, edges of the frame that are
   kept of a line and floats of each. */
#define HF_EDGE_LINE 8 /* pixel, normal, step of colour that is usual there, 1 where that is known */
#define HF_EDGE_REACH 10
#define HF_EDGE_CANDIDATES 4
#define HF_EDGE_CANDIDATE 8  /* pixels along the normal, weight 0 to 1, step of colour, 0 */
#define HF_EDGE_NOISE2 4e-5f /* squared step of colour, all channels, that noise makes */
#define HF_EDGE_UNLIKE 0.1f  /* weight that a step unlike the usual one keeps */

#ifndef __OPENCL_VERSION__
namespace holdfast::kernel {
#endif

typedef struct {
  int x, y, width, height;
} hf_rect;

/* A level image: pixel (x, y) is element origin + y * stride + x. */
typedef struct {
  int stride, origin;
} hf_layout;

typedef struct {
  int width, height;  /* of the frame */
  int offset, stride; /* bytes */
  int distorted;      /* 1: undistort; 2: a fisheye's picture, whose k1 to k4 are k1, k2, p1, p2 */
  float fx, fy, cx, cy;
  float k1, k2, p1, p2, k3, k4, k5, k6;
} hf_frame;

/* Rendered pixels packed in a region buffer. */
typedef struct {
  int stride; /* pixels */
  int grey;   /* 1: the frame has one channel, so must the view */
  float near_plane, far_plane;
} hf_view;

/* What of the rendered view may be compared with the frame, and its planes. */
typedef struct {
  int width, height;    /* of the frame */
  int plane;            /* floats from a plane to the next */
  float least_coverage; /* share of the blur's reach that must be known surface */
  float jump;           /* relative step of depth that is an edge */
  int reach;            /* pixels from an edge that are dropped */
  float bend;           /* relative bend of 1/Z from a pixel to the next at an edge between faces; 0: kept */
} hf_template;

/* Where a rendered pixel is sampled in the frame: x' = project(D backproject(x, Z)), equation 5 of docs/math.md. */
typedef struct {
  float d[12];                      /* D, rows of 3x4 */
  float fx, fy, cx, cy;             /* camera of this level */
  float turn[4];                    /* 2x2, rows: turns frame gradients into the rendered view's axes */
  float min_x, min_y, max_x, max_y; /* where the frame may be sampled, level pixels */
  int every;                        /* every how manieth row of pixels is looked at; 1: all */
  int still;                        /* 1: D is the identity, so every pixel is sampled where it is */
} hf_warp;

/* What the object does while the shutter is open: a point P moves by v + w x P, half of it before the frame's pose. */
typedef struct {
  float v[3], w[3];
  float fx, fy, cx, cy; /* camera of this level */
  int taps;             /* moments that are averaged */
  int across;           /* 1: as far at right angles to the motion, for comparison */
  int light;            /* 1: averaged as light, nearly the square of what is encoded; 0: as encoded */
} hf_exposure;

typedef struct {
  int gradient_test, angle_test, magnitude_test, angle_together;
  float gradient_minimum2; /* squared */
  float angle_cosine2;     /* squared cosine of the largest angle */
  float difference_maximum;
  float difference_relative; /* added: this share of the larger magnitude */
} hf_tests;

typedef struct {
  float center[3]; /* reference point of rotation, camera frame */
  float radius;    /* scale of translation, metres */
  float fx, fy, cx, cy;
  int every; /* rows, as in hf_warp */
  int block_vote;
  int vote_radius; /* at most HF_VOTE_RADIUS */
  float vote_share;
  int robust;
  float inverse_scale2; /* 1 / sigma^2 of the residual */
  float freedom;        /* degrees of freedom of Student's t */
  int redundancy;
  float redundancy_cosine2;
  float gradient_minimum2; /* a channel of less has no row of its own beside redundant ones */
  float saturated;         /* a channel of the frame at least so bright may be clipped, and weighs nothing */
  int elimination;         /* 1: cells sum what eliminating their pairs needs, not only moments and depth */
} hf_constraints;

typedef struct {
  float d[12];          /* D, rows of 3x4: where the contour's points have moved since the view was drawn */
  float fx, fy, cx, cy; /* camera of this level */
  float center[3];      /* reference point of rotation, camera frame */
  float radius;         /* scale of translation, metres */
  hf_rect region;       /* pixels of the level that hold the frame */
  int count;            /* lines */
  int reach;            /* pixels looked at on either side */
  float step;           /* pixels between the sixteen places of the edge that are told apart */
  float softness2;      /* squared: half the pixels that the edge is blurred over */
  float trust;          /* in colours, below 0.5: what no edge explains must stay possible */
  float variance;       /* square pixels, of every line's edge beside what its colours leave open */
  int by_shares;        /* 1: the edge is where the shares of both sides' colours put it */
  int beside, around;   /* pixels at the edge that show shares, and up to which the sides' colours are taken */
  float far2;           /* square of the distance at which a line weighs half; 0: all weigh fully */
} hf_contour;

typedef struct {
  hf_rect region; /* pixels of the level that hold the frame */
  int count;      /* lines */
} hf_edges;

#ifndef __OPENCL_VERSION__
}  // namespace holdfast::kernel
#endif
#endif
