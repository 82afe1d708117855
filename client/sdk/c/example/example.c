/* A scan to a server, then the pose 100 times a second: example HOST:PORT MAP */
#include <dcloc.h>
#include <stdio.h>
#include <time.h>

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  dcloc_config* config = dcloc_config_new(argv[1], argv[2], "example");
  dcloc_config_add_radar(config, "front", (double[]){3.5, 0, 0}, (double[]){1, 0, 0, 0}, 0.0);
  double covariance[36] = {[0] = 1, [7] = 1, [14] = 0.1, [21] = 1e-4, [28] = 1e-4, [35] = 0.01};
  dcloc_config_set_initial_pose(config, (double[]){0, 0, 0}, (double[]){1, 0, 0, 0}, covariance);
  dcloc_session* session = NULL;
  if (dcloc_session_open(config, &session) != DCLOC_OK) return puts(dcloc_error_text()), 1;
  int64_t now_ns = 1700000000000000000;
  dcloc_scan scan = {.struct_size = sizeof scan, .stamp_ns = now_ns, .radar_id = "front"};
  dcloc_answer answer = {.struct_size = sizeof answer};
  if (dcloc_session_send_scan(session, &scan) || dcloc_session_next(session, &answer)) return 1;
  printf("answer %lld, state %d\n", (long long)answer.sequence_number, (int)answer.pose.state);
  for (int i = 0; i < 10; ++i, now_ns += 10000000) {
    dcloc_session_add_ego_velocity(session, now_ns, (double[]){20, 0, 0, 0, 0, 0});
    dcloc_pose pose = {.struct_size = sizeof pose};
    if (dcloc_session_smooth_pose_at(session, now_ns, &pose) != DCLOC_OK) puts(dcloc_error_text());
    else printf("x %.3f y %.3f\n", pose.translation_m[0], pose.translation_m[1]);
    nanosleep(&(struct timespec){.tv_nsec = 10000000}, NULL);
  }
  dcloc_session_free(session);
  dcloc_config_free(config);
  return 0;
}
