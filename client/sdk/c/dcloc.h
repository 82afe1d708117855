/* The client of dcloc for C and whatever calls C: localization sessions over gRPC, and the
 * vehicle's pose at any time.
 *
 * Functions return DCLOC_OK or why not; dcloc_error_text() then says it in words. No exception
 * leaves them. Sessions may be used by several threads at once, configurations by one at a time.
 * Pointers that are given are only looked at during the call; NULL where none is allowed is
 * refused.
 *
 * The ABI is stable within a SONAME. Structs begin with their size, so that they can grow: set
 * struct_size to sizeof the struct before each call. */
#ifndef DCLOC_H_
#define DCLOC_H_

#include <stddef.h>
#include <stdint.h>

/* Names as C has them. NOLINTBEGIN(readability-identifier-naming) */

#ifdef __cplusplus
extern "C" {
#endif

/* The numbers of gRPC. */
typedef enum dcloc_status {
  DCLOC_OK = 0,
  DCLOC_CANCELLED = 1,
  DCLOC_UNKNOWN = 2,
  DCLOC_INVALID_ARGUMENT = 3,
  DCLOC_DEADLINE_EXCEEDED = 4,
  DCLOC_NOT_FOUND = 5,
  DCLOC_ALREADY_EXISTS = 6,
  DCLOC_PERMISSION_DENIED = 7,
  DCLOC_RESOURCE_EXHAUSTED = 8,
  DCLOC_FAILED_PRECONDITION = 9,
  DCLOC_ABORTED = 10,
  DCLOC_OUT_OF_RANGE = 11,
  DCLOC_UNIMPLEMENTED = 12,
  DCLOC_INTERNAL = 13,
  DCLOC_UNAVAILABLE = 14,
  DCLOC_DATA_LOSS = 15,
  DCLOC_UNAUTHENTICATED = 16
} dcloc_status;

typedef enum dcloc_state {
  DCLOC_STATE_INITIALIZING = 1, /* no pose in the map is confirmed yet */
  DCLOC_STATE_TRACKING = 2,
  DCLOC_STATE_DEAD_RECKONING = 3,
  DCLOC_STATE_LOST = 4
} dcloc_state;

/* "0.1.0". */
const char* dcloc_version(void);

/* What the last call of this thread that failed had to say; "" before. Valid until the next one. */
const char* dcloc_error_text(void);

/* ---- What a session needs */

typedef struct dcloc_config dcloc_config;

/* For a server HOST:PORT, a map of its, and a name of the vehicle in logs. NULL when memory is
 * short. */
dcloc_config* dcloc_config_new(const char* server, const char* map, const char* vehicle);
void dcloc_config_free(dcloc_config* config); /* NULL is let be */

/* TLS with the authority's certificate, and the vehicle's own certificate and key, or NULL. */
dcloc_status dcloc_config_set_tls(dcloc_config* config, const char* ca_file, const char* cert_file,
                                  const char* key_file);
dcloc_status dcloc_config_set_token_file(dcloc_config* config, const char* file);

/* A radar by its frame in the vehicle frame (x ahead, y left, z up): translation [m], rotation as a
 * unit quaternion (w, x, y, z), and the range-Doppler coupling [s]. At least one is needed. */
dcloc_status dcloc_config_add_radar(dcloc_config* config, const char* radar_id,
                                    const double translation_m[3], const double rotation_wxyz[4],
                                    double beta_s);

/* The vehicle in the map frame, where it is known; else the whole map is searched. The covariance
 * is row-major of (x, y, z, rotation about x, y, z), about the map's axes. */
dcloc_status dcloc_config_set_initial_pose(dcloc_config* config, const double translation_m[3],
                                           const double rotation_wxyz[4],
                                           const double covariance[36]);

/* For how long a broken connection is mended, 2 minutes by default; 0: the session ends with it. */
dcloc_status dcloc_config_set_reconnect_ms(dcloc_config* config, int64_t give_up_after_ms);

/* For programs that only ask for poses: answers that are not taken are forgotten, the oldest first,
 * and dcloc_session_next need not be called. */
dcloc_status dcloc_config_forget_answers(dcloc_config* config);

/* ---- A session */

typedef struct dcloc_session dcloc_session;

/* Waits until the server has opened it, at most 10 s. */
dcloc_status dcloc_session_open(const dcloc_config* config, dcloc_session** session);
/* Ends it if it has not ended. No other call may be under way. NULL is let be. */
void dcloc_session_free(dcloc_session* session);

/* A scan as columns of target_count; those that the radar does not measure are NULL. */
typedef struct dcloc_scan {
  size_t struct_size;
  int64_t sequence_number; /* ascending, >= 0 */
  int64_t stamp_ns;        /* on the vehicle's clock, since 1970 */
  const char* radar_id;
  size_t target_count;
  const float* range_m;
  const float* range_rate_mps; /* positive away from the radar */
  const float* azimuth_rad;    /* counter-clockwise from the radar's x axis */
  const float* elevation_rad;  /* or NULL */
  const float* rcs_dbsm;       /* or NULL */
  const double* ego_velocity;  /* or NULL: x, y, z [m/s], turn rates about x, y, z [rad/s] */
} dcloc_scan;

/* Queues a scan and does not wait. DCLOC_RESOURCE_EXHAUSTED when too many wait already. */
dcloc_status dcloc_session_send_scan(dcloc_session* session, const dcloc_scan* scan);

/* What wheels and gyroscope say, each at its own rate, for dcloc_session_pose_at: forward speed,
 * and turn rate about z; NAN for the one that this tick does not tell. Scans that are sent with a
 * NULL ego_velocity get theirs from here. */
dcloc_status dcloc_session_add_motion(dcloc_session* session, int64_t stamp_ns, double speed_mps,
                                      double yaw_rate_radps);

/* The vehicle's velocity as a whole at any rate, for dcloc_session_pose_at: x, y, z
 * [m/s], turn rates about x, y, z [rad/s], in the vehicle frame. Nothing is sent. */
dcloc_status dcloc_session_add_ego_velocity(dcloc_session* session, int64_t stamp_ns,
                                            const double velocity[6]);

typedef struct dcloc_pose {
  size_t struct_size;
  int64_t stamp_ns;
  int64_t answer_stamp_ns; /* of the answer that it goes out from */
  double translation_m[3]; /* the vehicle in the map frame */
  double rotation_wxyz[4];
  double covariance[36]; /* as in dcloc_config_set_initial_pose */
  double velocity[6];    /* as in dcloc_session_add_ego_velocity */
  int32_t state;         /* dcloc_state of that answer */
} dcloc_pose;

/* Where the vehicle was at a stamp, between answers or at most 0.5 s after the newest. Takes no
 * lock. DCLOC_FAILED_PRECONDITION while there is no pose, DCLOC_OUT_OF_RANGE too far ahead or back.
 */
dcloc_status dcloc_session_pose_at(const dcloc_session* session, int64_t stamp_ns,
                                   dcloc_pose* pose);
/* The same without jumps, for controllers. */
dcloc_status dcloc_session_smooth_pose_at(const dcloc_session* session, int64_t stamp_ns,
                                          dcloc_pose* pose);

typedef struct dcloc_answer {
  size_t struct_size;
  int64_t sequence_number;   /* the scan's */
  int32_t rejection;         /* a dcloc_status; but for DCLOC_OK the scan was refused */
  double protection_level_m; /* negative: none is promised */
  dcloc_pose pose;           /* without a velocity; not set when the scan was refused */
} dcloc_answer;

/* Waits for the next answer: one for each scan, in their order. They must be taken, or no more
 * scans are sent, but after dcloc_config_forget_answers. Once the session has ended and all are
 * taken, DCLOC_OUT_OF_RANGE. */
dcloc_status dcloc_session_next(dcloc_session* session, dcloc_answer* answer);

/* No more scans will come; those that were sent are answered, then the session ends. */
dcloc_status dcloc_session_close_sending(dcloc_session* session);
/* Ends the session without waiting. */
dcloc_status dcloc_session_cancel(dcloc_session* session);
/* Why it has ended; DCLOC_FAILED_PRECONDITION while it has not. */
dcloc_status dcloc_session_end_status(const dcloc_session* session);

#ifdef __cplusplus
}
#endif

/* NOLINTEND(readability-identifier-naming) */

#endif /* DCLOC_H_ */
