// Exceptions: save everything into an ExceptionFrame (bsp/bare/exception.h), ask C++, go on.
// Source  Arm ARM D1.10 (vector table).
#include "bsp/bare/arch.h"

#define FRAME_BYTES  816
#define FRAME_PC     248              // after x0..x30
#define FRAME_Q      304

    .text
    .macro  entry kind
    .balign 128
    sub     sp, sp, #FRAME_BYTES
    stp     x0, x1, [sp]
    mov     x0, #\kind
    b       save
    .endm

    .balign 2048
    .global exception_vectors
exception_vectors:
    entry   0                       // from the code, on SP_EL0: synchronous
    entry   1                       // interrupt
    entry   2                       // fast interrupt
    entry   3                       // system error
    entry   4                       // from a handler, on SP_EL1
    entry   5
    entry   6
    entry   7
    .rept   8                       // from EL0: nothing runs there
    entry   8
    .endr

save:
    stp     x2, x3, [sp, #16]
    stp     x4, x5, [sp, #32]
    stp     x6, x7, [sp, #48]
    stp     x8, x9, [sp, #64]
    stp     x10, x11, [sp, #80]
    stp     x12, x13, [sp, #96]
    stp     x14, x15, [sp, #112]
    stp     x16, x17, [sp, #128]
    stp     x18, x19, [sp, #144]
    stp     x20, x21, [sp, #160]
    stp     x22, x23, [sp, #176]
    stp     x24, x25, [sp, #192]
    stp     x26, x27, [sp, #208]
    stp     x28, x29, [sp, #224]
    str     x30, [sp, #240]
    mrs     x1, elr_el1
    mrs     x2, spsr_el1
    mrs     x3, sp_el0
    mrs     x4, esr_el1
    mrs     x5, far_el1
    mrs     x6, fpcr
    mrs     x7, fpsr
    str     x1, [sp, #FRAME_PC]
    stp     x2, x3, [sp, #FRAME_PC + 8]
    stp     x4, x5, [sp, #FRAME_PC + 24]
    stp     x6, x7, [sp, #FRAME_PC + 40]
    add     x1, sp, #FRAME_Q
    stp     q0, q1, [x1, #0]
    stp     q2, q3, [x1, #32]
    stp     q4, q5, [x1, #64]
    stp     q6, q7, [x1, #96]
    stp     q8, q9, [x1, #128]
    stp     q10, q11, [x1, #160]
    stp     q12, q13, [x1, #192]
    stp     q14, q15, [x1, #224]
    stp     q16, q17, [x1, #256]
    stp     q18, q19, [x1, #288]
    stp     q20, q21, [x1, #320]
    stp     q22, q23, [x1, #352]
    stp     q24, q25, [x1, #384]
    stp     q26, q27, [x1, #416]
    stp     q28, q29, [x1, #448]
    stp     q30, q31, [x1, #480]
    mov     x1, sp
    bl      exception_entry         // (kind, frame); comes back from interrupts alone

    add     x1, sp, #FRAME_Q
    ldp     q0, q1, [x1, #0]
    ldp     q2, q3, [x1, #32]
    ldp     q4, q5, [x1, #64]
    ldp     q6, q7, [x1, #96]
    ldp     q8, q9, [x1, #128]
    ldp     q10, q11, [x1, #160]
    ldp     q12, q13, [x1, #192]
    ldp     q14, q15, [x1, #224]
    ldp     q16, q17, [x1, #256]
    ldp     q18, q19, [x1, #288]
    ldp     q20, q21, [x1, #320]
    ldp     q22, q23, [x1, #352]
    ldp     q24, q25, [x1, #384]
    ldp     q26, q27, [x1, #416]
    ldp     q28, q29, [x1, #448]
    ldp     q30, q31, [x1, #480]
    ldr     x1, [sp, #FRAME_PC]
    ldr     x2, [sp, #FRAME_PC + 8]
    ldp     x6, x7, [sp, #FRAME_PC + 40]
    msr     elr_el1, x1
    msr     spsr_el1, x2
    msr     fpcr, x6
    msr     fpsr, x7
    ldp     x2, x3, [sp, #16]
    ldp     x4, x5, [sp, #32]
    ldp     x6, x7, [sp, #48]
    ldp     x8, x9, [sp, #64]
    ldp     x10, x11, [sp, #80]
    ldp     x12, x13, [sp, #96]
    ldp     x14, x15, [sp, #112]
    ldp     x16, x17, [sp, #128]
    ldp     x18, x19, [sp, #144]
    ldp     x20, x21, [sp, #160]
    ldp     x22, x23, [sp, #176]
    ldp     x24, x25, [sp, #192]
    ldp     x26, x27, [sp, #208]
    ldp     x28, x29, [sp, #224]
    ldr     x30, [sp, #240]
    ldp     x0, x1, [sp]
    add     sp, sp, #FRAME_BYTES
    eret
