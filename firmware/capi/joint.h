/* The joint's observer for firmware in C. Made from the library's source: change it there.
   Link libjoint.a; docs/integration.md says how it is built, for a drive and for a desktop. It allocates nothing, cannot panic, and keeps all its state in the joint_t that it is given. */

#ifndef JOINT_H
#define JOINT_H

#include <stddef.h>
#include <stdint.h>

/**
 * Version of this header: major, minor and patch, a byte each.
 */
#define JOINT_VERSION 256

/**
 * Eight-byte words of a joint.
 */
#define JOINT_WORDS 768

/**
 * Most gear stages.
 */
#define JOINT_STAGES 3

/**
 * All went well.
 */
#define JOINT_OK 0

/**
 * A pointer is null or not aligned.
 */
#define JOINT_POINTER -1

/**
 * The joint was not initialised.
 */
#define JOINT_NOT_INITIALISED -2

/**
 * There is no parameter block: the memory is erased.
 */
#define JOINT_BLOCK_EMPTY 1

/**
 * This is no parameter block.
 */
#define JOINT_BLOCK_MAGIC 2

/**
 * The block is of a version that this library does not know.
 */
#define JOINT_BLOCK_VERSION 3

/**
 * The block is shorter or longer than it says.
 */
#define JOINT_BLOCK_LENGTH 4

/**
 * The block's checksum is wrong.
 */
#define JOINT_BLOCK_CRC 5

/**
 * The block's joint has too many stages.
 */
#define JOINT_BLOCK_STAGES 6

/**
 * The block's payload cannot be read.
 */
#define JOINT_BLOCK_PAYLOAD 7

/**
 * The block holds a value that the equations cannot take.
 */
#define JOINT_BLOCK_INADMISSIBLE 8

/**
 * The block is of an older version and has effects, which that version numbers otherwise: export it anew.
 */
#define JOINT_BLOCK_EFFECTS 10

/**
 * Bit of `status`: no parameters were accepted: estimates are those of the documented default joint.
 */
#define JOINT_STATUS_DEFAULTS (1 << 0)

/**
 * Bit of `status`: a measurement was no number, or beyond what its sensor can show, and was left out.
 */
#define JOINT_STATUS_MEASUREMENT (1 << 1)

/**
 * Bit of `status`: the motor encoder moved further than the joint can in one period.
 */
#define JOINT_STATUS_ENCODER_JUMP (1 << 2)

/**
 * Bit of `status`: control periods were missed before this one.
 */
#define JOINT_STATUS_LATE (1 << 3)

/**
 * Bit of `status`: the output stage is enabled.
 */
#define JOINT_STATUS_OUTPUT_ON (1 << 4)

/**
 * Bit of `health`: the state is still settling after a start.
 */
#define JOINT_HEALTH_STARTING (1 << 0)

/**
 * Bit of `health`: the load cannot be seen: the joint is held by friction and no sensor is behind it.
 */
#define JOINT_HEALTH_UNOBSERVABLE (1 << 1)

/**
 * Bit of `health`: no rotor angle came with this sample; the model alone went on.
 */
#define JOINT_HEALTH_COASTING (1 << 2)

/**
 * Bit of `health`: a measurement was too far off to be believed, and was left out.
 */
#define JOINT_HEALTH_GLITCH (1 << 3)

/**
 * Bit of `health`: the very same measurements as before while the joint moved: left out.
 */
#define JOINT_HEALTH_REPEATED (1 << 4)

/**
 * Bit of `health`: the current sensor is at its end or silent; the current was left out.
 */
#define JOINT_HEALTH_NO_CURRENT (1 << 5)

/**
 * Bit of `health`: the applied voltage (or current) was not a number; the last one was kept.
 */
#define JOINT_HEALTH_NO_DRIVE (1 << 6)

/**
 * Bit of `health`: the innovations stay larger than the design says: wrong parameters, or a drive that does not put out what it is told.
 */
#define JOINT_HEALTH_MISMATCH (1 << 7)

/**
 * Bit of `health`: an estimate is at the bound it is held to.
 */
#define JOINT_HEALTH_BOUNDED (1 << 8)

/**
 * Bit of `health`: there is no estimate: no rotor angle has come yet, or for too long.
 */
#define JOINT_HEALTH_LOST (1 << 9)

/**
 * A joint: memory for the library, not to be looked into. It may be moved between calls.
 */
typedef struct {
  uint64_t memory[JOINT_WORDS];
} joint_t;

/**
 * What the drive measured in one control period.
 */
typedef struct {
  /**
   * DC-equivalent voltage on the two conducting phases, V, held until the next sample.
   */
  float voltage_v;
  /**
   * Motor current, A.
   */
  float current_a;
  /**
   * Counts of the motor encoder since the start, over all turns.
   */
  int32_t motor_counts;
  /**
   * Counts of the output encoder since the start; zero where there is none.
   */
  int32_t output_counts;
  /**
   * Control periods that were missed before this one.
   */
  uint32_t missed;
} joint_sample_t;

/**
 * What is estimated, and one standard deviation of each.
 */
typedef struct {
  /**
   * Control periods since the start.
   */
  uint32_t tick;
  /**
   * What is wrong or special, the bits JOINT_STATUS_...; zero where all is well.
   */
  uint16_t status;
  /**
   * What the observer says of itself, the bits JOINT_HEALTH_...; zero where all is well.
   */
  uint16_t health;
  /**
   * Rotor speed, rad/s.
   */
  float motor_velocity_rad_per_s;
  /**
   * Friction of all masses, felt at the motor, Nm, positive against positive motion.
   */
  float total_friction_at_motor_nm;
  /**
   * Angle behind the last stage, rad.
   */
  float output_angle_rad;
  /**
   * Speed behind the last stage, rad/s.
   */
  float output_velocity_rad_per_s;
  /**
   * Load torque at the output, Nm, positive against positive motion.
   */
  float load_torque_nm;
  /**
   * Deflection of each stage's spring at its output, rad; zero where there is no such stage.
   */
  float windup_rad[JOINT_STAGES];
  /**
   * Standard deviation of the rotor speed.
   */
  float motor_velocity_std;
  /**
   * Standard deviation of the friction.
   */
  float total_friction_std;
  /**
   * Standard deviation of the output angle.
   */
  float output_angle_std;
  /**
   * Standard deviation of the output speed.
   */
  float output_velocity_std;
  /**
   * Standard deviation of the load torque.
   */
  float load_torque_std;
  /**
   * Standard deviation of each deflection.
   */
  float windup_std[JOINT_STAGES];
} joint_estimate_t;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Version of the library: equal to JOINT_VERSION where header and library belong together.
 */
uint32_t joint_version(void);

/**
 * Prepares a joint from a parameter block, as "joint export --format block" writes it; what follows
 * the block in memory is not looked at. The joint is at rest. Returns JOINT_OK or why the block is
 * refused, and then the joint is not initialised.
 *
 * joint points to a joint_t of the caller's, block to length readable bytes; a null pointer is
 * refused.
 */
int32_t joint_init(joint_t *joint, const uint8_t *block, size_t length);

/**
 * Advances the joint by one control period. Never blocks, and costs the same whatever the data.
 * Returns JOINT_OK, or why nothing was done.
 *
 * joint points to a joint_t that was given to joint_init or is all zeros, sample to a sample; a
 * null pointer is refused.
 */
int32_t joint_update(joint_t *joint, const joint_sample_t *sample);

/**
 * Reads what the last update left. Returns JOINT_OK, or why nothing was read.
 *
 * joint is as for joint_update, estimate points to a place for an estimate; a null pointer is
 * refused.
 */
int32_t joint_estimate(const joint_t *joint, joint_estimate_t *estimate);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* JOINT_H */
