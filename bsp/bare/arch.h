// Bits of system registers and page table entries, for the assembler files alone.
// Source  Arm ARM for A-profile, D5.3 (descriptors), D13.2 (registers).
#pragma once

// clang-format off
#define TEXT_OFFSET          0x200000
#define RESTART              0x100
#define CURRENT_EL2          (2 << 2)
#define HCR_EL2_RW           (1 << 31)                // EL1 is AArch64
#define CNTHCTL_EL2_EL1_MAY  0x3                      // EL1PCTEN, EL1PCEN
#define CPTR_EL2_NO_TRAP     0x33ff                   // RES1 bits alone
#define MDCR_EL2_HPMN        0x1f                     // all event counters are EL1's
#define ICC_SRE_EL2          S3_4_C12_C9_5
#define ICC_SRE_ALL          0xf                      // Enable, DIB, DFB, SRE
#define SPSR_EL1H_MASKED     0x3c5                    // D A I F, EL1 with SP_EL1
#define CPACR_EL1_FP         (3 << 20)                // no trap of FP and NEON
#define SCTLR_EL1_RES1       0x30d00800
#define SCTLR_EL1_ON         (SCTLR_EL1_RES1 | 1 << 12 | 1 << 3 | 1 << 2 | 1)  // I, SA, C, M

#define MAIR_EL1_KINDS       0xff04                   // 0: device nGnRE; 1: write-back memory
// T0SZ, write back, inner, EPD1
#define TCR_EL1_4GIB         (32 | 1 << 8 | 1 << 10 | 3 << 12 | 1 << 23 | 2 << 32)

#define PAGE_BYTES           4096
#define BLOCK_SHIFT          21
#define CACHE_LINE           64
#define TABLE                0x3
#define ENTRY_DATA           (3 << 53 | 1 << 10 | 3 << 8 | 1 << 2)  // UXN PXN, AF, inner, attr 1
#define ENTRY_READ_ONLY      (ENTRY_DATA | 1 << 7)
#define BLOCK_DEVICE         (3 << 53 | 1 << 10 | 1)  // UXN PXN, AF, attr 0
#define BLOCK_DATA           (ENTRY_DATA | 1)
#define BLOCK_READ_ONLY      (ENTRY_READ_ONLY | 1)
#define PAGE_DATA            (ENTRY_DATA | 3)
#define PAGE_CONSTANT        (ENTRY_READ_ONLY | 3)
#define PAGE_CODE            (1 << 54 | 1 << 10 | 3 << 8 | 1 << 7 | 1 << 2 | 3)
// clang-format on
