/* Counts what a program executes, block by block, and where its time would go in real caches.
 *
 * In      -plugin plugin.so,out=FILE,begin=ADDRESS,end=ADDRESS
 *         begin, end: the functions trace_mark_begin and trace_mark_end of core/trace, whose only
 *         store goes to the place that begins or ends: from its address the estimator reads the
 *         place's name in the ELF file. Both may be 0: one segment then.
 * Out     FILE, little-endian, records one after the other (record.py reads them):
 *         'B' block: u32 id, u64 address, u32 instructions, u32 words[instructions]
 *         'S' segment, what one CPU did between two marks: u32 cpu, u64 place now on top of the
 *             CPU's stack (0: none), u8 what ends it ('b' begin, 'e' end, 'x' exit), u64 place of
 *             that mark, u64 instructions executed by all CPUs so far, u32 number of executions,
 *             u32 number of events; executions {u32 block, u32 count}; events {u32 block *
 *             kEvents + kind, u32 count}.
 * Errors  A block that an exception or an access to a device leaves early counts as a whole.
 *         Instructions and data of all CPUs go through private L1 and one shared L2.
 *         Only for one thread of emulation: user mode without threads, or system mode with -icount.
 * Cost    About 5 times the emulator's own time. */
#include <stdio.h>

#include "branch_model.h"
#include "cache_model.h"
#include "qemu_plugin.h"

QEMU_PLUGIN_EXPORT int qemu_plugin_version = QEMU_PLUGIN_API_VERSION;

enum { kCpusMax = 8, kPlacesDeepMax = 32, kWordsMax = 512, kBuckets = 1 << 16 };
enum { kCores = 2 };
/* Event kinds: per core instruction fetch, then data, each as Access without kCacheHit; after them
 * a branch at the block's end that was predicted wrongly, the same for all cores. */
enum { kFetch = 0, kData = 4, kKinds = 8, kMispredicted = kCores * kKinds, kEvents };

typedef struct Block {
  struct Block* next; /* in its bucket */
  uint64_t address;
  uint32_t id;
  uint32_t instructions;
  Branch branch; /* its last instruction */
  /* Since the segment of that CPU began: */
  bool listed[kCpusMax]; /* among touched */
  uint32_t executed[kCpusMax];
  uint32_t events[kCpusMax][kEvents];
} Block;

/* Geometry from the cores' technical reference manuals, sizes as the RK3399 has them. */
static const struct {
  uint32_t l1i_bytes, l1i_ways, l1d_bytes, l1d_ways, l2_bytes, l2_ways, streams;
} kGeometry[kCores] = {
    {48 << 10, 3, 32 << 10, 2, 1 << 20, 16, 8},   /* Cortex-A72 */
    {32 << 10, 2, 32 << 10, 4, 512 << 10, 16, 4}, /* Cortex-A53 */
};

typedef struct {
  Block** touched; /* with a count since the segment began */
  uint32_t touched_count, touched_max;
  uint64_t places[kPlacesDeepMax];
  uint32_t places_deep;
  Block* running;
  Predictor predictor;
  struct {
    Cache l1i, l1d;
    Streams fetched, loaded;
  } core[kCores];
} Cpu;

static FILE* out;
static uint64_t mark_begin, mark_end;
static Block* buckets[kBuckets];
static uint32_t blocks;
static uint64_t instructions;
static Cpu cpus[kCpusMax];
static Cache l2[kCores];

static void put(const void* data, size_t bytes) {
  if (fwrite(data, 1, bytes, out) != bytes) {
    perror("profiler plugin: cannot write");
    exit(1);
  }
}
static void put8(uint8_t v) { put(&v, sizeof v); }
static void put32(uint32_t v) { put(&v, sizeof v); }
static void put64(uint64_t v) { put(&v, sizeof v); }

static uint64_t top_place(const Cpu* cpu) {
  return cpu->places_deep == 0 ? 0 : cpu->places[cpu->places_deep - 1];
}

static void end_segment(uint32_t index, uint8_t why, uint64_t place) {
  Cpu* const cpu = &cpus[index];
  uint32_t events = 0;
  for (uint32_t i = 0; i < cpu->touched_count; ++i)
    for (uint32_t k = 0; k < kEvents; ++k) events += cpu->touched[i]->events[index][k] > 0;
  put8('S');
  put32(index);
  put64(top_place(cpu));
  put8(why);
  put64(place);
  put64(instructions);
  put32(cpu->touched_count);
  put32(events);
  for (uint32_t i = 0; i < cpu->touched_count; ++i) {
    put32(cpu->touched[i]->id);
    put32(cpu->touched[i]->executed[index]);
  }
  for (uint32_t i = 0; i < cpu->touched_count; ++i) {
    Block* const block = cpu->touched[i];
    for (uint32_t k = 0; k < kEvents; ++k) {
      if (block->events[index][k] == 0) continue;
      put32(block->id * kEvents + k);
      put32(block->events[index][k]);
    }
    block->listed[index] = false;
    block->executed[index] = 0;
    memset(block->events[index], 0, sizeof block->events[index]);
  }
  cpu->touched_count = 0;
}

/* ---- while the program runs ------------------------------------------------------------------ */

static void on_mark_begin(unsigned index, qemu_plugin_meminfo_t info, uint64_t place, void* none) {
  (void)info;
  (void)none;
  end_segment(index, 'b', place);
  Cpu* const cpu = &cpus[index];
  if (cpu->places_deep < kPlacesDeepMax) cpu->places[cpu->places_deep++] = place;
}

static void on_mark_end(unsigned index, qemu_plugin_meminfo_t info, uint64_t place, void* none) {
  (void)info;
  (void)none;
  end_segment(index, 'e', place);
  if (cpus[index].places_deep > 0) --cpus[index].places_deep;
}

static void touch(Cpu* cpu, uint32_t index, Block* block) {
  if (block->listed[index]) return;
  block->listed[index] = true;
  if (cpu->touched_count == cpu->touched_max) {
    cpu->touched_max = cpu->touched_max == 0 ? 1024 : 2 * cpu->touched_max;
    cpu->touched = realloc(cpu->touched, cpu->touched_max * sizeof(Block*));
  }
  cpu->touched[cpu->touched_count++] = block;
}

static void predict(Cpu* cpu, uint32_t index, Block* ended, uint64_t next) {
  const uint64_t branch = ended->address + 4 * (ended->instructions - 1);
  if (predictor_knew(&cpu->predictor, ended->branch, branch, next)) return;
  touch(cpu, index, ended);
  ++ended->events[index][kMispredicted];
}

static void on_block(unsigned index, void* context) {
  Block* const block = context;
  Cpu* const cpu = &cpus[index];
  if (cpu->running != NULL) predict(cpu, index, cpu->running, block->address);
  cpu->running = block;
  instructions += block->instructions;
  touch(cpu, index, block);
  ++block->executed[index];
  const uint64_t first = block->address / kLineBytes;
  const uint64_t last = (block->address + 4 * block->instructions - 1) / kLineBytes;
  for (int c = 0; c < kCores; ++c) {
    for (uint64_t line = first; line <= last; ++line) {
      const Access access = cache_access(&cpu->core[c].l1i, &l2[c], &cpu->core[c].fetched, line);
      if (access != kCacheHit) ++block->events[index][c * kKinds + kFetch + access - 1];
    }
  }
}

static void on_access(unsigned index, qemu_plugin_meminfo_t info, uint64_t address, void* none) {
  (void)none;
  Cpu* const cpu = &cpus[index];
  if (cpu->running == NULL) return;
  const uint64_t first = address / kLineBytes;
  const uint64_t last = (address + (1u << qemu_plugin_mem_size_shift(info)) - 1) / kLineBytes;
  for (int c = 0; c < kCores; ++c) {
    for (uint64_t line = first; line <= last; ++line) {
      const Access access = cache_access(&cpu->core[c].l1d, &l2[c], &cpu->core[c].loaded, line);
      if (access != kCacheHit) {
        touch(cpu, index, cpu->running); /* a mark in this block may have ended the segment */
        ++cpu->running->events[index][c * kKinds + kData + access - 1];
      }
    }
  }
}

/* ---- when a block is translated -------------------------------------------------------------- */

static Block* find_block(uint64_t address, uint32_t count, const uint32_t* words) {
  Block** const bucket = &buckets[(address / 4 * 31 + count) % kBuckets];
  for (Block* block = *bucket; block != NULL; block = block->next)
    if (block->address == address && block->instructions == count) return block;
  Block* const block = calloc(1, sizeof(Block));
  block->next = *bucket;
  *bucket = block;
  block->address = address;
  block->id = blocks++;
  block->instructions = count;
  block->branch = branch_of(words[count - 1]);
  put8('B');
  put32(block->id);
  put64(address);
  put32(count);
  put(words, count * sizeof *words);
  return block;
}

static bool is_in_mark(uint64_t address, uint64_t mark) {
  return mark != 0 && address >= mark && address < mark + 16;
}

static void on_translation(qemu_plugin_id_t id, struct qemu_plugin_tb* tb) {
  (void)id;
  uint32_t words[kWordsMax];
  const size_t count = qemu_plugin_tb_n_insns(tb);
  const uint64_t address = qemu_plugin_tb_vaddr(tb);
  if (count > kWordsMax) {
    fprintf(stderr, "profiler plugin: a block of %zu instructions\n", count);
    exit(1);
  }
  for (size_t i = 0; i < count; ++i) {
    struct qemu_plugin_insn* const insn = qemu_plugin_tb_get_insn(tb, i);
    memcpy(&words[i], qemu_plugin_insn_data(insn), sizeof words[i]);
    qemu_plugin_register_vcpu_mem_cb(insn, on_access, QEMU_PLUGIN_CB_NO_REGS, QEMU_PLUGIN_MEM_RW,
                                     NULL);
    const uint64_t at = address + 4 * i;
    if (is_in_mark(at, mark_begin))
      qemu_plugin_register_vcpu_mem_cb(insn, on_mark_begin, QEMU_PLUGIN_CB_NO_REGS,
                                       QEMU_PLUGIN_MEM_W, NULL);
    if (is_in_mark(at, mark_end))
      qemu_plugin_register_vcpu_mem_cb(insn, on_mark_end, QEMU_PLUGIN_CB_NO_REGS, QEMU_PLUGIN_MEM_W,
                                       NULL);
  }
  qemu_plugin_register_vcpu_tb_exec_cb(tb, on_block, QEMU_PLUGIN_CB_NO_REGS,
                                       find_block(address, (uint32_t)count, words));
}

static void finish(qemu_plugin_id_t id, void* none) {
  (void)id;
  (void)none;
  for (uint32_t i = 0; i < kCpusMax; ++i)
    if (cpus[i].touched_count > 0) end_segment(i, 'x', 0);
  if (fclose(out) != 0) perror("profiler plugin: cannot write");
}

QEMU_PLUGIN_EXPORT int qemu_plugin_install(qemu_plugin_id_t id, const qemu_info_t* info, int argc,
                                           char** argv) {
  if (strcmp(info->target_name, "aarch64") != 0) {
    fprintf(stderr, "profiler plugin: only for aarch64, not %s\n", info->target_name);
    return 1;
  }
  for (int i = 0; i < argc; ++i) {
    if (strncmp(argv[i], "out=", 4) == 0) out = fopen(argv[i] + 4, "wb");
    if (strncmp(argv[i], "begin=", 6) == 0) mark_begin = strtoull(argv[i] + 6, NULL, 16);
    if (strncmp(argv[i], "end=", 4) == 0) mark_end = strtoull(argv[i] + 4, NULL, 16);
  }
  if (out == NULL) {
    perror("profiler plugin: out=FILE is needed and must be writable");
    return 1;
  }
  for (int c = 0; c < kCores; ++c) {
    cache_init(&l2[c], kGeometry[c].l2_bytes, kGeometry[c].l2_ways);
    for (int i = 0; i < kCpusMax; ++i) {
      cache_init(&cpus[i].core[c].l1i, kGeometry[c].l1i_bytes, kGeometry[c].l1i_ways);
      cache_init(&cpus[i].core[c].l1d, kGeometry[c].l1d_bytes, kGeometry[c].l1d_ways);
      cpus[i].core[c].fetched.used = cpus[i].core[c].loaded.used = kGeometry[c].streams;
    }
  }
  qemu_plugin_register_vcpu_tb_trans_cb(id, on_translation);
  qemu_plugin_register_atexit_cb(id, finish, NULL);
  return 0;
}
