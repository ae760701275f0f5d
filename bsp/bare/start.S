// From the loader to C++: mapped memory, caches on, a stack with a guard, at EL1.
// In      x0: device tree, or 0. EL2 or EL1, memory not mapped, as for an arm64 Linux image.
// Out     bare_main() on core 0; bare_core_main(core) on the others.
// Source  Linux Documentation/arm64/booting.rst; Arm ARM D5 (translation), D13 (registers).
#include "bsp/bare/arch.h"

// ---- the head of the image ---------------------------------------------------------------------
    .section .text.head, "ax"
    .global _head
_head:
    b       start                   // code0
    .long   0                       // code1
    .quad   TEXT_OFFSET             // from the base of DRAM
    .quad   __image_bytes
    .quad   0x2                     // little endian, 4 KiB pages, near the base of DRAM
    .quad   0, 0, 0
    .ascii  "ARM\x64"
    .long   0

start:
    mov     x20, x0                 // device tree
    mrs     x19, CurrentEL
    cmp     x19, #CURRENT_EL2
    b.ne    1f
    bl      drop_to_el1
1:  adr     x0, _head               // the code does not move: it must lie where it was linked
    ldr     x1, =_head
    cmp     x0, x1
    b.eq    2f
    bl      move_image
2:  bl      build_tables
    mov     x0, x20
    bl      map_device_tree
    bl      map_memory_on
    mov     x0, #0
    bl      set_stacks
    ldr     x1, =boot_registers     // from here on memory is cached
    stp     x20, x19, [x1]
    mov     x21, #0
    b       warm

// Again, memory mapped, only this core running: what a restart jumps to.
    .global bare_restart
bare_restart:
    msr     daifset, #0xf
    mov     x0, #0
    bl      set_stacks
    mov     x21, #1
warm:
    ldr     x0, =__data_begin
    ldr     x1, =__data_load
    ldr     x2, =__data_end
1:  cmp     x0, x2
    b.hs    2f
    ldp     x3, x4, [x1], #16
    stp     x3, x4, [x0], #16
    b       1b
2:  ldr     x0, =__bss_begin
    ldr     x2, =__bss_end
    bl      zero
    ldr     x0, =__pools_begin
    ldr     x2, =__pools_end
    bl      zero
    mov     x29, #0                 // the outermost frame
    mov     x30, #0
    mov     x0, x21                 // is it a restart?
    b       bare_main

// x0..x2, both multiples of 16
zero:
    cmp     x0, x2
    b.hs    1f
    stp     xzr, xzr, [x0], #16
    b       zero
1:  ret

// Another core, by PSCI: x0 is its number. Or core 0 after a fault of another: x0 is RESTART.
    .global bare_core_start
bare_core_start:
    mov     x20, x0
    mrs     x19, CurrentEL
    cmp     x19, #CURRENT_EL2
    b.ne    1f
    bl      drop_to_el1
1:  bl      map_memory_on
    cmp     x20, #RESTART
    b.eq    bare_restart
    mov     x0, x20
    bl      set_stacks
    mov     x0, x20
    mov     x29, #0
    mov     x30, #0
    b       bare_core_main

// ---- exception level ---------------------------------------------------------------------------
// From EL2 to the caller at EL1: no trap to EL2 for timer, PMU, FP and the GIC's system registers.
drop_to_el1:
    mov     x1, #HCR_EL2_RW
    msr     hcr_el2, x1
    mov     x1, #CNTHCTL_EL2_EL1_MAY
    msr     cnthctl_el2, x1
    msr     cntvoff_el2, xzr
    mov     x1, #CPTR_EL2_NO_TRAP
    msr     cptr_el2, x1
    mrs     x1, mdcr_el2
    and     x1, x1, #MDCR_EL2_HPMN
    msr     mdcr_el2, x1
    mrs     x1, id_aa64pfr0_el1
    ubfx    x1, x1, #24, #4         // GIC
    cbz     x1, 1f
    mov     x1, #ICC_SRE_ALL
    msr     ICC_SRE_EL2, x1
    isb
1:  ldr     x1, =SCTLR_EL1_RES1
    msr     sctlr_el1, x1
    mov     x1, #SPSR_EL1H_MASKED
    msr     spsr_el2, x1
    msr     elr_el2, x30
    eret

// x0: core. C++ runs on SP_EL0, exceptions on SP_EL1: a report needs a stack when that of the code
// is what has run out. Per core, upwards: guard, stack, guard, exception stack.
set_stacks:
    msr     tpidr_el1, x0           // this core's number
    ldr     x1, =__stack_bytes
    ldr     x2, =__exception_stack_bytes
    add     x3, x1, x2
    add     x3, x3, #2 * PAGE_BYTES // of one core
    ldr     x4, =__stacks_begin
    madd    x4, x0, x3, x4
    add     x1, x4, x1
    add     x1, x1, #PAGE_BYTES     // top of the stack
    add     x3, x4, x3              // top of the exception stack
    msr     spsel, #1
    mov     sp, x3
    msr     spsel, #0
    mov     sp, x1
    ldr     x1, =exception_vectors
    msr     vbar_el1, x1
    mov     x1, #CPACR_EL1_FP
    msr     cpacr_el1, x1
    isb
    ret

// The loader put the image elsewhere: copy it, go on there. x0 from, x1 to.
move_image:
    sub     x5, x1, x0
    ldr     x2, =__load_end
1:  ldp     x3, x4, [x0], #16
    stp     x3, x4, [x1], #16
    cmp     x1, x2
    b.lo    1b
    dsb     sy
    ic      iallu
    dsb     sy
    isb
    add     x30, x30, x5
    ret

// ---- memory map --------------------------------------------------------------------------------
// Level 1: 4 entries, each a level 2 table of 512 blocks of 2 MiB; the image's own block is a level
// 3 table of 4 KiB pages. What is not entered faults.
build_tables:
    mov     x15, x30
    ldr     x0, =__page_tables_begin
    ldr     x2, =__page_tables_end
    bl      zero
    ldr     x0, =level1
    ldr     x1, =level2
    mov     x2, #4
1:  orr     x3, x1, #TABLE
    str     x3, [x0], #8
    add     x1, x1, #PAGE_BYTES
    subs    x2, x2, #1
    b.ne    1b

    ldr     x0, =__devices_begin
    ldr     x1, =__devices_end
    ldr     x2, =BLOCK_DEVICE
    bl      map_blocks
    ldr     x0, =__pools_begin
    ldr     x1, =__pools_end
    ldr     x2, =BLOCK_DATA
    bl      map_blocks
    ldr     x0, =level2             // the image's block becomes a table
    ldr     x1, =__image_begin
    lsr     x1, x1, #BLOCK_SHIFT
    ldr     x2, =level3
    orr     x2, x2, #TABLE
    str     x2, [x0, x1, lsl #3]

    ldr     x0, =__image_begin
    ldr     x1, =__text_end
    ldr     x2, =PAGE_CODE
    bl      map_pages
    ldr     x0, =__text_end
    ldr     x1, =__rodata_end
    ldr     x2, =PAGE_CONSTANT
    bl      map_pages
    ldr     x0, =__rodata_end
    ldr     x1, =__stacks_begin
    ldr     x2, =PAGE_DATA
    bl      map_pages
    ldr     x5, =__stacks_begin     // guard, stack, guard, exception stack
    ldr     x8, =__stacks_end
2:  add     x0, x5, #PAGE_BYTES
    ldr     x1, =__stack_bytes
    add     x1, x0, x1
    bl      map_pages
    add     x0, x1, #PAGE_BYTES
    ldr     x1, =__exception_stack_bytes
    add     x1, x0, x1
    bl      map_pages
    mov     x5, x1
    cmp     x5, x8
    b.lo    2b

    ldr     x0, =__page_tables_begin // no stale line may hide them from the walker
    ldr     x2, =__page_tables_end
3:  dc      ivac, x0
    add     x0, x0, #CACHE_LINE
    cmp     x0, x2
    b.lo    3b
    dsb     sy
    mov     x30, x15
    ret

// x0: device tree or 0. It is at most 2 MiB long and may cross into a second block.
map_device_tree:
    cbz     x0, 1f
    mov     x15, x30
    lsr     x3, x0, #32
    cbnz    x3, 1f
    add     x1, x0, #1 << BLOCK_SHIFT
    ldr     x2, =BLOCK_READ_ONLY
    bl      map_new_blocks
    dsb     sy
    mov     x30, x15
1:  ret

// x0..x1 by blocks with the attributes x2; map_new_blocks leaves alone what is mapped.
map_blocks:
    mov     x7, #1
    b       1f
map_new_blocks:
    mov     x7, #0
1:  lsr     x3, x0, #BLOCK_SHIFT
    add     x1, x1, #1 << BLOCK_SHIFT
    sub     x1, x1, #1
    lsr     x1, x1, #BLOCK_SHIFT
    ldr     x4, =level2
2:  cmp     x3, x1
    b.hs    4f
    ldr     x6, [x4, x3, lsl #3]
    cbnz    x7, 3f
    cbnz    x6, 5f
3:  orr     x6, x2, x3, lsl #BLOCK_SHIFT
    str     x6, [x4, x3, lsl #3]
5:  add     x3, x3, #1
    b       2b
4:  ret

// x0..x1 by pages of the image's block with the attributes x2; keeps x1.
map_pages:
    ldr     x4, =level3
1:  cmp     x0, x1
    b.hs    2f
    ubfx    x3, x0, #12, #9
    orr     x6, x2, x0
    str     x6, [x4, x3, lsl #3]
    add     x0, x0, #PAGE_BYTES
    b       1b
2:  ret

map_memory_on:
    ldr     x1, =MAIR_EL1_KINDS
    msr     mair_el1, x1
    ldr     x1, =TCR_EL1_4GIB
    msr     tcr_el1, x1
    ldr     x1, =level1
    msr     ttbr0_el1, x1
    isb
    tlbi    vmalle1
    ic      iallu
    dsb     sy
    isb
    ldr     x1, =SCTLR_EL1_ON
    msr     sctlr_el1, x1
    isb
    ret

    .section .page_tables, "aw", @nobits
    .balign PAGE_BYTES
level2:                             // four tables, one after the other
    .global bare_level2
bare_level2:
    .space  4 * PAGE_BYTES
level3:
    .space  PAGE_BYTES
level1:
    .space  PAGE_BYTES

    .section .kept, "aw", @nobits
    .balign 16
    .global boot_registers
boot_registers:                     // device tree, CurrentEL
    .space  16
