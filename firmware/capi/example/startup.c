/* Reset of the MPS2 board with a Cortex-M4F in QEMU; the C library's own start does the rest. */
#include <stdint.h>

extern uint32_t __stack[];
extern void _start(void);

static void reset(void) {
    /* The FPU, before any code uses it. */
    *(volatile uint32_t *)0xe000ed88 |= 0xfu << 20;
    __asm volatile("dsb\n isb");
    _start();
}

static void hang(void) {
    for (;;) {
    }
}

__attribute__((section(".vectors"), used)) const void *const vectors[16] = {
    __stack, (const void *)reset, (const void *)hang, (const void *)hang,
    (const void *)hang, (const void *)hang, (const void *)hang,
};
