/* The observer in a C program: reads a parameter block and samples by semihosting, runs the
   observer over them, and writes every estimate. On a board the loop is the control interrupt. */
#include <stdio.h>

#include "../joint.h"

static joint_t joint;
static uint8_t block[8192];

static int fail(const char *what, int32_t code) {
    printf("error: %s: %ld\n", what, (long)code);
    return 1;
}

int main(void) {
    FILE *file = fopen("parameters.bin", "rb");
    if (file == NULL) return fail("parameters.bin", 0);
    size_t length = fread(block, 1, sizeof block, file);
    fclose(file);

    joint_estimate_t estimate;
    int32_t code = joint_estimate(&joint, &estimate);
    if (code != JOINT_NOT_INITIALISED) return fail("a joint of zeros is not initialised", code);
    code = joint_init(&joint, block, length);
    if (code != JOINT_OK) return fail("joint_init", code);

    FILE *samples = fopen("samples.bin", "rb");
    FILE *estimates = fopen("estimates.bin", "wb");
    if (samples == NULL || estimates == NULL) return fail("samples.bin, estimates.bin", 0);
    static struct { float voltage_v, current_a; int32_t motor_counts, output_counts; } row[64];
    static joint_estimate_t rows[64];
    unsigned count = 0;
    size_t read;
    while ((read = fread(row, sizeof row[0], 64, samples)) > 0) {
        for (size_t k = 0; k < read; k++) {
            joint_sample_t sample = {row[k].voltage_v, row[k].current_a, row[k].motor_counts,
                                     row[k].output_counts, 0};
            code = joint_update(&joint, &sample);
            if (code != JOINT_OK) return fail("joint_update", code);
            code = joint_estimate(&joint, &rows[k]);
            if (code != JOINT_OK) return fail("joint_estimate", code);
        }
        fwrite(rows, sizeof rows[0], read, estimates);
        count += read;
    }
    fclose(estimates);
    printf("samples=%u\n", count);
    printf("joint_bytes=%u\n", (unsigned)sizeof joint);
    return 0;
}
