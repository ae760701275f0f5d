/* Poses of an ASL recording with PGM images, one a line (TUM): poses FOLDER/mav0 CALIBRATION
 *   cc poses.c -lpirvs -o poses */
#include <pirvs.h>
#include <stdio.h>

static uint8_t pixels[2][1280 * 1024];
static char path[4096];

static FILE* open_file(const char* mode, const char* mav0, const char* sensor, const char* name) {
  snprintf(path, sizeof path, "%s/%s/%s", mav0, sensor, name);
  return fopen(path, mode);
}

static const uint8_t* read_pgm(const char* mav0, int camera, const char* name) {
  int width = 0, height = 0;
  FILE* file = open_file("rb", mav0, camera == 0 ? "cam0/data" : "cam1/data", name);
  if (file == NULL || fscanf(file, "P5 %d %d 255%*c", &width, &height) != 2) return NULL;
  const int rows = (int)fread(pixels[camera], (size_t)width, (size_t)height, file);
  fclose(file);
  return rows == height ? pixels[camera] : NULL;
}

static int check(pirvs_status status) {
  if (status < 0) fprintf(stderr, "poses: %s\n", pirvs_last_error());
  return status;
}

int main(int argc, char** argv) {
  if (argc != 3) return fprintf(stderr, "usage: poses FOLDER/mav0 CALIBRATION\n"), 2;
  pirvs_config config = {.size = sizeof config, .mode = PIRVS_STEPPED, .calibration = argv[2]};
  pirvs_imu imu = {.size = sizeof imu};
  pirvs_images images = {.size = sizeof images};
  pirvs_pose p = {.size = sizeof p};
  pirvs_slam* slam = NULL;
  if (check(pirvs_create(&config, &slam)) || check(pirvs_start(slam))) return 2;

  FILE *samples = open_file("r", argv[1], "imu0", "data.csv");
  FILE *frames = open_file("r", argv[1], "cam0", "data.csv");
  if (samples == NULL || frames == NULL) return perror(path), 2;
  (void)!fscanf(samples, "#%*[^\n]"), (void)!fscanf(frames, "#%*[^\n]");
  long long t, frame_t;
  char name[256];
  int more = fscanf(frames, "%lld,%255s", &frame_t, name) == 2;
  while (fscanf(samples, "%lld,%lf,%lf,%lf,%lf,%lf,%lf", &t, &imu.w_rad_s[0], &imu.w_rad_s[1],
                &imu.w_rad_s[2], &imu.f_m_s2[0], &imu.f_m_s2[1], &imu.f_m_s2[2]) == 7) {
    for (; more && frame_t < t; more = fscanf(frames, "%lld,%255s", &frame_t, name) == 2) {
      images.t_ns = frame_t;
      for (int c = 0; c < 2; ++c) images.image[c] = read_pgm(argv[1], c, name);
      check(pirvs_feed_images(slam, &images));
    }
    imu.t_ns = t;
    check(pirvs_feed_imu(slam, &imu));
    while (pirvs_next_pose(slam, PIRVS_AT_FRAME, &p) == PIRVS_OK) {
      t = p.t_ns;
      printf("%lld.%09lld %.9f %.9f %.9f %.9f %.9f %.9f %.9f\n", t / 1000000000,
             t % 1000000000, p.p_m[0], p.p_m[1], p.p_m[2], p.q_xyzw[0], p.q_xyzw[1],
             p.q_xyzw[2], p.q_xyzw[3]);
    }
  }
  const int status = check(pirvs_stop(slam));
  pirvs_destroy(slam);
  return status < 0;
}
