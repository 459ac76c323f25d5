/*
 * Context switches of a thread, from perf_event_open: for a software event that counts nothing (PERF_COUNT_SW_DUMMY)
 * with context_switch set, the kernel writes a record of 16 bytes to a ring each time that the thread leaves a CPU or
 * comes back, with the time of CLOCK_MONOTONIC. It needs no privilege up to perf_event_paranoid 2, because a thread
 * only learns about itself.
 *
 * Ring protocol (the kernel writes, any thread reads). The ring is mapped without write permission and written
 * backwards (write_backward): data_head falls by the size of a record once the record is whole, so the newest record
 * lies at data_head, older ones follow upwards, and the oldest are overwritten. The reader loads data_head, the records
 * and data_head again; of what it read, the bytes from (second data_head + size) on have been overwritten, and those of
 * the record before that may be under way. Source: the manual page perf_event_open(2), and kernel/events/ring_buffer.c
 * of Linux.
 *
 * The mapping keeps the event alive, so the descriptor is closed at once.
 */
#include "profiler/prof_internal.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/perf_event.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

/* A record consists of these two words, since sample_type asks for nothing but the time. */
typedef struct prof_switch_record {
	uint64_t header; /* struct perf_event_header */
	uint64_t ns;
} prof_switch_record;

#define PROF_SWITCH_BYTES (PROF_SWITCHES_MAX * sizeof(prof_switch_record))
static_assert(sizeof(struct perf_event_header) == sizeof(uint64_t), "one word");

static uint32_t prof_switches_wanted;

void stilb_prof_switches_set(bool on)
{
	__atomic_store_n(&prof_switches_wanted, on,
	                 __ATOMIC_RELAXED); /* read by prof_switches_open; no other data depends on it */
}

/* The reason why perf_event_open failed with this error. perf_event_paranoid: the kernel's default 2 allows a thread to
 * record its own switches; Debian's and Android's 3 forbids it. */
static const char *prof_switches_why(int error)
{
	char level[8] = "";
	if (error == ENOSYS)
		return "this kernel has no perf_event_open";
	if (error == EMFILE || error == ENFILE)
		return "no file descriptor left for perf_event_open";
	if (error != EPERM && error != EACCES)
		return "perf_event_open knows no context switches here";
	int file = open("/proc/sys/kernel/perf_event_paranoid", O_RDONLY | O_CLOEXEC);
	if (file >= 0) {
		if (read(file, level, sizeof level - 1) < 0)
			level[0] = 0;
		close(file);
	}
	return level[0] >= '3' && level[0] <= '9' ? "perf_event_paranoid is above 2"
	                                          : "perf_event_open is forbidden here (seccomp of a container?)";
}

static int prof_switches_event(void)
{
	struct perf_event_attr attr = {
		.type = PERF_TYPE_SOFTWARE,
		.size = sizeof attr,
		.config = PERF_COUNT_SW_DUMMY,
		.sample_type = PERF_SAMPLE_TIME,
		.sample_id_all = 1, /* the time in every record */
		.context_switch = 1,
		.exclude_kernel = 1,
		.exclude_hv = 1,
		.use_clockid = 1,
		.clockid = CLOCK_MONOTONIC,
		.write_backward = 1,
	};
	return (int)syscall(SYS_perf_event_open, &attr, 0, -1, -1, PERF_FLAG_FD_CLOEXEC);
}

prof_switches prof_switches_open(const char *name)
{
	assert(name);
	if (__atomic_load_n(&prof_switches_wanted, __ATOMIC_RELAXED) == 0) /* pairs with stilb_prof_switches_set */
		return (prof_switches){.refused = "not asked for"};
	int file = prof_switches_event();
	if (file < 0)
		return (prof_switches){.refused = prof_switches_why(errno), .schedstat = prof_schedstat_open(name)};
	/* The memory that all such rings of a user may lock is limited (perf_event_mlock_kb, RLIMIT_MEMLOCK): if it is used
	 * up, try smaller rings. */
	prof_switches switches = {.refused = "no locked memory left (RLIMIT_MEMLOCK)"};
	size_t page = (size_t)sysconf(_SC_PAGESIZE);
	for (size_t bytes = PROF_SWITCH_BYTES; bytes >= page && !switches.page; bytes /= 2) {
		void *memory = mmap(NULL, page + bytes, PROT_READ, MAP_SHARED, file, 0);
		if (memory != MAP_FAILED)
			switches = (prof_switches){.page = memory, .size = page + bytes, .process = getpid()};
	}
	close(file);
	if (!switches.page)
		switches.schedstat = prof_schedstat_open(name);
	return switches;
}

/* True if the kernel's ring is mapped in this process. Not in a child of fork, which does not get such mappings. */
static bool prof_switches_mapped(const prof_switches *switches)
{
	return switches->page && switches->process == getpid();
}

void prof_switches_close(prof_switches *switches)
{
	if (prof_switches_mapped(switches))
		munmap((void *)switches->page, switches->size);
	prof_schedstat_close(switches->schedstat);
	*switches = (prof_switches){0};
}

static void prof_switches_reverse(prof_switch_event *events, uint32_t count)
{
	for (uint32_t i = 0; i < count / 2; i++) {
		prof_switch_event event = events[i];
		events[i] = events[count - 1 - i];
		events[count - 1 - i] = event;
	}
}

uint32_t prof_switches_copy(const prof_switches *switches, uint64_t since_ns, prof_switch_event *events)
{
	assert(events);
	if (!prof_switches_mapped(switches))
		return 0;
	const struct perf_event_mmap_page *page = switches->page;
	const char *data = (const char *)page + page->data_offset;
	uint64_t size = page->data_size;
	uint32_t count = 0;

	/* Acquire: pairs with the barrier that the kernel puts between a record and data_head. data_head starts at 0 and
	 * falls, so its negative is the number of bytes written. */
	uint64_t head = __atomic_load_n(&page->data_head, __ATOMIC_ACQUIRE);
	uint64_t written = -head, held = written < size ? written : size;
	bool older = true;
	for (uint64_t i = 0; i < held && older; i += sizeof(prof_switch_record)) {
		/* Acquire: the second load of data_head, which tells what was overwritten, comes after these loads. */
		const prof_switch_record *record = (const prof_switch_record *)(data + ((head + i) & (size - 1)));
		uint64_t header = __atomic_load_n(&record->header, __ATOMIC_ACQUIRE);
		uint64_t ns = __atomic_load_n(&record->ns, __ATOMIC_ACQUIRE);
		struct perf_event_header parts;
		memcpy(&parts, &header, sizeof parts);
		assert(count < PROF_SWITCHES_MAX);
		events[count++] = (prof_switch_event){
			.ns = ns,
			.in = (parts.misc & PERF_RECORD_MISC_SWITCH_OUT) == 0,
			.preempted = (parts.misc & PERF_RECORD_MISC_SWITCH_OUT_PREEMPT) != 0,
		};
		older = ns > since_ns;
	}
	/* The oldest records are invalid: those overwritten since the first load, and one that may be being written. */
	uint64_t now = __atomic_load_n(&page->data_head, __ATOMIC_RELAXED); /* ordered by the acquire loads before it */
	uint64_t fresh = (head - now) / sizeof(prof_switch_record) + 1, slots = size / sizeof(prof_switch_record);
	uint64_t valid = slots > fresh ? slots - fresh : 0;
	if (count > valid)
		count = (uint32_t)valid;
	prof_switches_reverse(events, count);
	return count;
}
