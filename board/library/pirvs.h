/* PIRVS as a library: a program feeds images and IMU samples, and gets poses. C99 and C++.
 *
 *   link with -lpirvs; docs/api.md; examples in C, C++ and Python: board/library/examples
 *
 * In      A calibration file (`pirvs calibration` writes it), grey images, IMU samples in SI units,
 *         stamps in ns. Images are stamped at the middle of their exposure; IMU samples and images
 *         on the same clock but for the calibration's offset.
 * Out     Poses at each IMU sample and at each image pair, with covariance, confidence and reasons
 *         to doubt them; map points; what happened; counters.
 * Frames  world: z up, origin at the first keyframe. body: the IMU. Attitude: quaternion x y z w
 *         that takes body to world.
 * Units   m, rad, s, m/s, rad/s, m/s^2; times in ns.
 * Errors  Calls return pirvs_status: 0 done, above 0 nothing to worry about, below 0 refused;
 *         pirvs_last_error() says why, for a person. No exception leaves the library. A bug of the
 *         library's own prints one line and aborts.
 * Cost    65 MB of static memory, of which a run touches what it needs. From
 *         pirvs_start() to pirvs_stop() nothing is allocated.
 * Threads One instance in a process. Next to each function stands who may call it:
 *           [owner]   one thread at a time, and no other call of this instance meanwhile
 *           [feeder]  one thread at a time; IMU samples and images may come from two
 *           [reader]  one thread at a time for each function, beside all others
 *           [any]     any thread at any time
 *         PIRVS_STEPPED: every call is as [owner]. Callbacks come on the library's own thread
 *         (PIRVS_LIVE) or within the call that feeds (PIRVS_STEPPED); they return soon, and call
 *         nothing that is [owner] or [feeder], nor a command.
 * ABI     Every struct begins with its size, which the caller sets: a program that was built with
 *         an older header goes on with a newer library. Fields are added at the end. Zero means: as
 *         by default. */
#ifndef PIRVS_H
#define PIRVS_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Names as a C library has them. NOLINTBEGIN(readability-identifier-naming) */

#define PIRVS_API __attribute__((visibility("default")))

typedef struct pirvs_slam pirvs_slam;

typedef enum pirvs_status {
  PIRVS_OK = 0,
  PIRVS_EMPTY = 1,         /* nothing there now */
  PIRVS_FULL = 2,          /* not taken, and counted: the stack is behind (PIRVS_LIVE) */
  PIRVS_BAD_ARGUMENT = -1, /* NULL, a size of no version, a value that cannot be */
  PIRVS_BAD_DATA = -2,     /* a file that is no such file, or makes no sense */
  PIRVS_NOT_FOUND = -3,    /* no such file, parameter */
  PIRVS_REFUSED = -4,      /* not in this state: before the start, after the stop, in a callback */
  PIRVS_IO = -5,           /* the disk or the system refuses */
  PIRVS_TIMEOUT = -6       /* a command was not answered in time, and may be obeyed yet */
} pirvs_status;

/* What drives the stack. */
enum {
  PIRVS_LIVE = 0,   /* threads of its own, by the clock: for sensors. Feeding never waits */
  PIRVS_STEPPED = 1 /* the thread that feeds, in the call that feeds: for recordings. The same input
                       gives the same bytes; after the call all poses that it made are there */
};

enum pirvs_health {
  PIRVS_INITIALIZING = 0,
  PIRVS_TRACKING = 1,
  PIRVS_DEGRADED = 2,
  PIRVS_LOST = 3
};

/* Why a pose is to be doubted, by bit: pirvs_pose.reasons. */
enum {
  PIRVS_BLIND = 1 << 0,      /* too little is seen: dead reckoning */
  PIRVS_REJECTED = 1 << 1,   /* much of what is seen is not where it should be */
  PIRVS_JUMPS = 1 << 2,      /* corrections of its own, again and again */
  PIRVS_ACCEL_BIAS = 1 << 3, /* beyond what an accelerometer has */
  PIRVS_GYRO_BIAS = 1 << 4,  /* beyond what a gyro has */
  PIRVS_SPEED = 1 << 5,      /* beyond what the device can do */
  PIRVS_STAMPS = 1 << 6,     /* one sensor's may be wrong */
  PIRVS_DENIED = 1 << 7,     /* what ran before this start was hopeless */
  PIRVS_PLATFORM = 1 << 8,   /* what is seen moves along with the device */
  PIRVS_CAMERAS = 1 << 9,    /* they disagree */
  PIRVS_TURN = 1 << 10       /* gyro and image turn against each other: axes? */
};

typedef struct pirvs_pose {
  uint32_t size;
  uint32_t health;
  int64_t t_ns;       /* on the IMU's clock */
  int64_t t_frame_ns; /* of the images that it stands on */
  double p_m[3];
  double q_xyzw[4];
  double v_m_s[3];        /* in world */
  double w_rad_s[3];      /* in body */
  double cov[9 * 9];      /* of attitude (body), position, velocity (world), by rows; rad, m, m/s */
  float confidence;       /* 0: do not use; 1: as good as it gets */
  uint32_t reasons;       /* to doubt it, by bit; 0: none */
  uint32_t resets;        /* changes whenever the pose may have jumped */
  float jump_m, jump_rad; /* size of the last jump */
  uint32_t epoch;         /* poses of different epochs have no known relation */
  uint32_t in_map;        /* 1: it stands in the frame of the map that was loaded */
  uint32_t dead_reckoning; /* 1: the images are older than 0.3 s */
} pirvs_pose;

enum { PIRVS_AT_IMU = 0, PIRVS_AT_FRAME = 1 }; /* which poses */

/* What happened: tracking began, was lost, was localised, why. */
typedef struct pirvs_news {
  uint32_t size;
  uint32_t health; /* from then on */
  int64_t t_ns;
  char text[160];
} pirvs_news;

typedef struct pirvs_config {
  uint32_t size;
  uint32_t mode;           /* PIRVS_LIVE, PIRVS_STEPPED */
  const char* calibration; /* file; needed */
  const char* folder;      /* where maps are; NULL: the working directory */
  uint32_t cores;          /* PIRVS_LIVE: threads, 1 to 3; 0: 3 */
  uint32_t mono;           /* 1: the left camera alone, whatever the calibration says */
  uint32_t monotonic;      /* 1: stamps are of CLOCK_MONOTONIC: latency is measured */
  uint32_t points;         /* 1: pirvs_get_points() is wanted */
  void* context;           /* of the callbacks, each of which may be NULL */
  void (*on_pose)(void* context, const pirvs_pose* pose);  /* at each IMU sample */
  void (*on_frame)(void* context, const pirvs_pose* pose); /* at each image pair */
  void (*on_news)(void* context, const pirvs_news* news);
} pirvs_config;

typedef struct pirvs_imu {
  uint32_t size;
  uint32_t reserved;
  int64_t t_ns;
  double w_rad_s[3]; /* angular rate */
  double f_m_s2[3];  /* specific force: +g upwards at rest */
} pirvs_imu;

/* Grey, a byte a pixel, of the calibration's size; copied before the call returns. */
typedef struct pirvs_images {
  uint32_t size;
  uint32_t stride; /* bytes from row to row; 0: the width */
  int64_t t_ns;
  const uint8_t* image[2]; /* left, right; NULL: this one is missing */
} pirvs_images;

typedef struct pirvs_point {
  uint64_t id; /* one point keeps it as long as it is in the map */
  double p_m[3];
  double sigma_m;
} pirvs_point;

typedef struct pirvs_points {
  uint32_t size;
  uint32_t point_size; /* sizeof(pirvs_point) */
  pirvs_point* point;  /* room for `max` */
  uint32_t max;
  uint32_t count; /* out */
  int64_t t_ns;   /* out: of the images in which they were seen */
} pirvs_points;

typedef struct pirvs_state {
  uint32_t size;
  uint32_t health;
  uint32_t running;   /* 1: between start and stop */
  uint32_t localised; /* 1: in the map that was loaded */
  float confidence;
  uint32_t reasons;
  uint64_t imu_fed, imu_lost, images_fed, images_lost; /* lost: PIRVS_FULL */
  uint64_t poses_lost, frames_lost;                    /* that nobody took in time, 64 wait */
  float imu_to_pose_ms;                                /* median; 0 unless `monotonic` */
} pirvs_state;

/* Of the library: 1.2+3.gHASH, by its tag. [any] */
PIRVS_API const char* pirvs_version(void);
/* Of this thread's last call that returned less than 0; "" before. Valid until the next. [any] */
PIRVS_API const char* pirvs_last_error(void);

/* Reads the calibration. PIRVS_REFUSED: there is an instance already. [owner] */
PIRVS_API pirvs_status pirvs_create(const pirvs_config* config, pirvs_slam** out);
/* PIRVS_LIVE: when it returns, the threads run. [owner] */
PIRVS_API pirvs_status pirvs_start(pirvs_slam* slam);

/* In order of time. [feeder] */
PIRVS_API pirvs_status pirvs_feed_imu(pirvs_slam* slam, const pirvs_imu* sample);
/* In order of time; from a recording after the samples up to their time. [feeder] */
PIRVS_API pirvs_status pirvs_feed_images(pirvs_slam* slam, const pirvs_images* images);

/* The oldest pose not yet taken; `which`: PIRVS_AT_IMU, PIRVS_AT_FRAME. `out->size` is the
 * caller's. PIRVS_EMPTY: none. Also after the stop. 64 of each kind are kept: who is slower
 * loses the oldest. [reader] */
PIRVS_API pirvs_status pirvs_next_pose(pirvs_slam* slam, int which, pirvs_pose* out);
/* The oldest news not yet taken; 16 are kept. [reader] */
PIRVS_API pirvs_status pirvs_next_news(pirvs_slam* slam, pirvs_news* out);
/* The map points that the newest images show. PIRVS_EMPTY: none since the last call. [reader] */
PIRVS_API pirvs_status pirvs_get_points(pirvs_slam* slam, pirvs_points* out);
/* [any] */
PIRVS_API pirvs_status pirvs_get_state(pirvs_slam* slam, pirvs_state* out);
/* Counter `index`, from 0, of all that was rejected or went wrong; PIRVS_EMPTY: there are no more.
 * [any] */
PIRVS_API pirvs_status pirvs_get_counter(pirvs_slam* slam, int index, const char** name,
                                         uint64_t* value);

/* Commands wait until they are obeyed, at most 10 s. PIRVS_REFUSED: not possible now. [any]
 * `name`: group.name as `pirvs params --all` lists them; before the start, too. */
PIRVS_API pirvs_status pirvs_set_parameter(pirvs_slam* slam, const char* name, double value);
/* Forgets the map; the world begins where the next start does. */
PIRVS_API pirvs_status pirvs_reset(pirvs_slam* slam);
/* The present pose is p_m with this heading. sigma_m > 0, in a loaded map that was not recognised
 * yet: a hint, this uncertain; the map stays where it is. */
PIRVS_API pirvs_status pirvs_set_pose(pirvs_slam* slam, const double p_m[3], double yaw_rad,
                                      double sigma_m);
/* A file of `folder`, by at most 63 characters. */
PIRVS_API pirvs_status pirvs_save_map(pirvs_slam* slam, const char* name);
/* What runs is given up; a start looks for its place in that map. */
PIRVS_API pirvs_status pirvs_load_map(pirvs_slam* slam, const char* name);

/* What was fed is tracked and mapped to its end. PIRVS_BAD_DATA: tracking never found a start.
 * [owner] */
PIRVS_API pirvs_status pirvs_stop(pirvs_slam* slam);
/* Stops it if it runs; another may be created then. NULL is fine. [owner] */
PIRVS_API void pirvs_destroy(pirvs_slam* slam);

/* NOLINTEND(readability-identifier-naming) */

#ifdef __cplusplus
}
#endif

#endif
