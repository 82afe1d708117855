/* Scans and ticks to a server, the pose 100 times a second: example HOST:PORT MAP */
#include <dcloc.h>
#include <stdio.h>
#include <time.h>

static int64_t now_ns(void) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  return 1000000000LL * now.tv_sec + now.tv_nsec;
}

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  dcloc_config* config = dcloc_config_new(argv[1], argv[2], "example");
  dcloc_config_add_radar(config, "front", (double[]){3.5, 0, 0.5}, (double[]){1, 0, 0, 0}, 0.0);
  dcloc_config_forget_answers(config);
  dcloc_session* session = NULL;
  if (dcloc_session_open(config, &session) != DCLOC_OK) return puts(dcloc_error_text()), 1;
  dcloc_scan scan = {.struct_size = sizeof scan, .radar_id = "front"}; /* with its targets */
  dcloc_pose pose = {.struct_size = sizeof pose};
  for (int i = 0; i < 100; ++i, nanosleep(&(struct timespec){.tv_nsec = 10000000}, NULL)) {
    const int64_t stamp_ns = scan.stamp_ns = now_ns();
    scan.sequence_number = i;
    if (i % 5 == 0) dcloc_session_send_scan(session, &scan); /* as its radar measures */
    dcloc_session_add_motion(session, stamp_ns, 20.0, 0.0);  /* of wheels and gyroscope */
    if (dcloc_session_smooth_pose_at(session, stamp_ns, &pose)) puts(dcloc_error_text());
    else printf("x %.3f y %.3f\n", pose.translation_m[0], pose.translation_m[1]);
  }
  dcloc_session_free(session);
  dcloc_config_free(config);
  return 0;
}
