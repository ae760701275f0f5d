/* Caches of one kind of core, as far as addresses alone tell: hit or miss per line, least recently
 * used, a write allocates like a read.
 * In      Line numbers (address / 64) in the order of execution.
 * Out     What each access cost: kHit, or which level it missed, and whether a hardware prefetcher
 *         that follows lines in sequence would have asked for it before.
 * Errors  none. */
#ifndef PIRVS_TOOLS_PROF_CACHE_MODEL_H
#define PIRVS_TOOLS_PROF_CACHE_MODEL_H

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { kLineBytes = 64, kStreams = 8 };

typedef struct {
  uint32_t sets; /* need not be a power of two */
  uint32_t ways;
  uint64_t* lines; /* sets x ways, the latest used first; 0: empty */
} Cache;

static inline void cache_init(Cache* cache, uint32_t bytes, uint32_t ways) {
  cache->sets = bytes / kLineBytes / ways;
  cache->ways = ways;
  cache->lines = (uint64_t*)calloc((size_t)cache->sets * ways, sizeof(uint64_t));
}

/* True: the line was there. Afterwards it is there, as the latest used. */
static inline bool cache_touch(Cache* cache, uint64_t line) {
  uint64_t* set = cache->lines + (line % cache->sets) * cache->ways;
  if (set[0] == line) return true;
  uint32_t at = 1;
  while (at < cache->ways && set[at] != line) ++at;
  const bool hit = at < cache->ways;
  memmove(set + 1, set, (hit ? at : cache->ways - 1) * sizeof(uint64_t));
  set[0] = line;
  return hit;
}

/* The ends of the sequences of missed lines that are being followed. */
typedef struct {
  uint64_t last[kStreams];
  bool confirmed[kStreams];
  uint32_t used; /* how many a core of this kind follows, at most kStreams */
} Streams;

/* True: this miss continues a sequence whose first two lines had missed before. */
static inline bool streams_follow(Streams* streams, uint64_t line) {
  uint32_t at = 0;
  while (at < streams->used && line - streams->last[at] + 1 > 2) ++at;
  const bool known = at < streams->used;
  const bool prefetched = known && streams->confirmed[at];
  const uint32_t moved = known ? at : streams->used - 1;
  memmove(streams->last + 1, streams->last, moved * sizeof streams->last[0]);
  memmove(streams->confirmed + 1, streams->confirmed, moved * sizeof streams->confirmed[0]);
  streams->last[0] = line;
  streams->confirmed[0] = known;
  return prefetched;
}

typedef enum {
  kCacheHit,
  kMissL1, /* found in L2 */
  kMissL1Stream,
  kMissL2, /* found in memory */
  kMissL2Stream,
} Access;

static inline Access cache_access(Cache* l1, Cache* l2, Streams* streams, uint64_t line) {
  if (cache_touch(l1, line)) return kCacheHit;
  const bool prefetched = streams_follow(streams, line);
  if (cache_touch(l2, line)) return prefetched ? kMissL1Stream : kMissL1;
  return prefetched ? kMissL2Stream : kMissL2;
}

#endif
