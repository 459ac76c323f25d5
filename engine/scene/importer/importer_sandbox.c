#include "scene/importer/importer_sandbox.h"

#include "scene/open/scene_stream.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <signal.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

/* ---- limits ------------------------------------------------------------------------------------------------------ */

#define SANDBOX_FILES 4096 /* descriptors: one for each texture */

/* Sets both limits of a resource, to at most the hard limit so far. */
static bool sandbox_limit(__rlimit_resource_t what, rlim_t value)
{
	struct rlimit old;
	if (getrlimit(what, &old) != 0)
		return false;
	if (value > old.rlim_max)
		value = old.rlim_max;
	return setrlimit(what, &(struct rlimit){value, value}) == 0;
}

static bool sandbox_limits(uint64_t bytes)
{
	STILB_ASSERT(bytes > 0);
	bool good = sandbox_limit(RLIMIT_CORE, 0);                  /* crashes are expected */
	good &= sandbox_limit(RLIMIT_FSIZE, STILB_IMAGE_MAX_BYTES); /* of the memory files that hold pictures */
	good &= sandbox_limit(RLIMIT_NOFILE, SANDBOX_FILES);
	if (!IMPORTER_SANITIZED)
		good &= sandbox_limit(RLIMIT_AS, bytes);
	return good;
}

void importer_sandbox_allow_time(uint64_t seconds)
{
	struct rusage used;
	struct rlimit limit;
	long cpus = sysconf(_SC_NPROCESSORS_ONLN);
	if (getrusage(RUSAGE_SELF, &used) != 0 || getrlimit(RLIMIT_CPU, &limit) != 0)
		return;
	limit.rlim_cur =
		(rlim_t)(used.ru_utime.tv_sec + used.ru_stime.tv_sec) + 1 + seconds * (rlim_t)(cpus > 0 ? cpus : 1);
	if (limit.rlim_cur > limit.rlim_max)
		limit.rlim_cur = limit.rlim_max;
	setrlimit(RLIMIT_CPU, &limit);
}

/* ---- Landlock: files --------------------------------------------------------------------------------------------- */

/* All rights that Landlock's first version can forbid; later versions add to them. Source: landlock(7). */
#define SANDBOX_ACCESS_1 ((LANDLOCK_ACCESS_FS_MAKE_SYM << 1) - 1)
#define SANDBOX_ACCESS_READ                                                                                            \
	(LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR | LANDLOCK_ACCESS_FS_EXECUTE) /* libraries are mapped */

/* All rights, as bits, that this version of Landlock can forbid. */
static uint64_t sandbox_access(long version)
{
	STILB_ASSERT(version >= 1);
	uint64_t access = SANDBOX_ACCESS_1;
	if (version >= 2)
		access |= 1ull << 13; /* LANDLOCK_ACCESS_FS_REFER */
	if (version >= 3)
		access |= 1ull << 14; /* LANDLOCK_ACCESS_FS_TRUNCATE */
	if (version >= 5)
		access |= 1ull << 15; /* LANDLOCK_ACCESS_FS_IOCTL_DEV */
	return access;
}

static bool sandbox_allow_path(int rules, const char *path, uint64_t access)
{
	int file = open(path, O_PATH | O_CLOEXEC);
	if (file < 0)
		return true; /* a path that does not exist needs no rule */
	struct landlock_path_beneath_attr rule = {.allowed_access = access, .parent_fd = file};
	bool good = syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &rule, 0) == 0;
	close(file);
	return good;
}

/* Allows the module with OpenImageIO beside this program (image_foreign.c). */
static bool sandbox_allow_program(int rules)
{
	char folder[PATH_MAX];
	ssize_t length = readlink("/proc/self/exe", folder, sizeof folder - 1);
	char *slash = length > 0 ? memrchr(folder, '/', (size_t)length) : NULL;
	if (!slash)
		return true;
	snprintf(slash, (size_t)(folder + sizeof folder - slash), "/stilb-image-oiio.so");
	return sandbox_allow_path(rules, folder, LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_EXECUTE);
}

static bool sandbox_landlock(void)
{
	static const char *const libraries[] = {"/usr/lib", "/usr/lib64", "/usr/local/lib", "/lib", "/lib64", "/opt"};
	static const char *const files[] = {"/etc/ld.so.cache", "/etc/localtime", "/dev/null", "/dev/urandom",
	                                    "/sys/devices/system/cpu"};
	long version = syscall(SYS_landlock_create_ruleset, NULL, 0, LANDLOCK_CREATE_RULESET_VERSION);
	if (version < 1)
		return false;
	struct landlock_ruleset_attr handled = {.handled_access_fs = sandbox_access(version)};
	int rules = (int)syscall(SYS_landlock_create_ruleset, &handled, sizeof handled, 0);
	if (rules < 0)
		return false;
	bool good = sandbox_allow_program(rules);
	for (size_t i = 0; i < sizeof libraries / sizeof *libraries; i++)
		good &= sandbox_allow_path(rules, libraries[i], SANDBOX_ACCESS_READ);
	for (size_t i = 0; i < sizeof files / sizeof *files; i++)
		sandbox_allow_path(rules, files[i], LANDLOCK_ACCESS_FS_READ_FILE);
	if (IMPORTER_SANITIZED)
		good &= sandbox_allow_path(rules, "/proc/self", LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR);
	good = good && syscall(SYS_landlock_restrict_self, rules, 0) == 0;
	close(rules);
	return good;
}

/* ---- seccomp: system calls --------------------------------------------------------------------------------------- */

#if defined(__x86_64__)
#define SANDBOX_ARCH AUDIT_ARCH_X86_64
#elif defined(__aarch64__)
#define SANDBOX_ARCH AUDIT_ARCH_AARCH64
#else
#define SANDBOX_ARCH 0
#endif

/* The system calls that decoding, threads and the loading of libraries need. All others fail with EPERM. Some old ones
 * do not exist on every architecture. */
static const unsigned sandbox_calls[] = {
	SYS_read,
	SYS_readv,
	SYS_pread64,
	SYS_write,
	SYS_writev,
	SYS_lseek,
	SYS_close,
	SYS_fstat,
	SYS_newfstatat,
	SYS_statx,
	SYS_openat,
	SYS_faccessat,
	SYS_faccessat2,
	SYS_readlinkat,
	SYS_getdents64,
	SYS_getcwd,
	SYS_fcntl,
	SYS_dup,
	SYS_dup3,
	SYS_ftruncate,
	SYS_memfd_create,
	SYS_mmap,
	SYS_munmap,
	SYS_mprotect,
	SYS_mremap,
	SYS_madvise,
	SYS_brk,
	SYS_futex,
	SYS_exit,
	SYS_exit_group,
	SYS_set_robust_list,
	SYS_get_robust_list,
	SYS_rseq,
	SYS_set_tid_address,
	SYS_gettid,
	SYS_getpid,
	SYS_getppid,
	SYS_getuid,
	SYS_geteuid,
	SYS_getgid,
	SYS_getegid,
	SYS_uname,
	SYS_sysinfo,
	SYS_getrandom,
	SYS_getrusage,
	SYS_clock_gettime,
	SYS_clock_getres,
	SYS_clock_nanosleep,
	SYS_nanosleep,
	SYS_gettimeofday,
	SYS_sched_yield,
	SYS_sched_getaffinity,
	SYS_sched_getparam,
	SYS_sched_getscheduler,
	SYS_rt_sigaction,
	SYS_rt_sigprocmask,
	SYS_rt_sigreturn,
	SYS_sigaltstack,
	SYS_restart_syscall,
	SYS_membarrier,
	SYS_get_mempolicy,
	SYS_ppoll,
	SYS_sendmsg,
	SYS_sendto,
	SYS_recvmsg,
	SYS_getrlimit,
#ifdef __x86_64__
	SYS_open,
	SYS_stat,
	SYS_lstat,
	SYS_access,
	SYS_readlink,
	SYS_poll,
	SYS_arch_prctl,
	SYS_time,
	SYS_dup2,
#endif
#if IMPORTER_SANITIZED
	SYS_pipe2, /* the sanitizers write memory to a pipe to learn whether it is mapped */
#ifdef __x86_64__
	SYS_pipe,
#endif
#endif
};

#define SANDBOX_CALLS (sizeof sandbox_calls / sizeof *sandbox_calls)

#define LOAD(field) BPF_STMT(BPF_LD | BPF_W | BPF_ABS, (uint32_t)offsetof(struct seccomp_data, field))
#define LOAD_LOW(index) BPF_STMT(BPF_LD | BPF_W | BPF_ABS, (uint32_t)offsetof(struct seccomp_data, args[index]))
#define EQUAL(value, then, otherwise) BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, (value), (then), (otherwise))
#define ANY_BIT(bits, then, otherwise) BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, (bits), (then), (otherwise))
#define ALLOW BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW)
#define REFUSE(error) BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | (error))

static bool sandbox_seccomp(void)
{
	/* Allows threads but no processes, signals to itself, and its own limits of time and stack. Both architectures are
	 * little endian, so the low half of an argument comes first. */
	const struct sock_filter special[] = {
		LOAD(arch),
		EQUAL(SANDBOX_ARCH, 1, 0),
		REFUSE(EPERM),
		LOAD(nr),
		EQUAL(SYS_clone3, 0, 1), /* a filter cannot read its flags in memory; libc then uses clone */
		REFUSE(ENOSYS),
		EQUAL(SYS_clone, 0, 4),
		LOAD_LOW(0),
		ANY_BIT(CLONE_THREAD, 0, 1),
		ALLOW,
		REFUSE(EPERM),
		EQUAL(SYS_tgkill, 0, 4),
		LOAD_LOW(0),
		EQUAL((uint32_t)getpid(), 0, 1),
		ALLOW,
		REFUSE(EPERM),
		EQUAL(SYS_prlimit64, 0, 7),
		LOAD_LOW(0),
		EQUAL(0, 0, 4),
		LOAD_LOW(1),
		EQUAL(RLIMIT_CPU, 1, 0),
		EQUAL(RLIMIT_STACK, 0, 1), /* read by libraries that start a thread */
		ALLOW,
		REFUSE(EPERM),
		EQUAL(SYS_prctl, 0, 4),
		LOAD_LOW(0),
		EQUAL(PR_SET_NAME, 0, 1),
		ALLOW,
		REFUSE(EPERM),
	};
	struct sock_filter filter[sizeof special / sizeof *special + 2 * SANDBOX_CALLS + 1];
	unsigned short length = sizeof special / sizeof *special;
	memcpy(filter, special, sizeof special);
	for (size_t i = 0; i < SANDBOX_CALLS; i++) {
		filter[length++] = (struct sock_filter)EQUAL(sandbox_calls[i], 0, 1);
		filter[length++] = (struct sock_filter)ALLOW;
	}
	filter[length++] = (struct sock_filter)REFUSE(EPERM);
	STILB_ASSERT(length == sizeof filter / sizeof *filter);
	struct sock_fprog program = {.len = length, .filter = filter};
	return SANDBOX_ARCH && syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, 0, &program) == 0;
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

uint32_t importer_sandbox_enter(uint64_t bytes)
{
	uint32_t flags = 0;
	prctl(PR_SET_PDEATHSIG, SIGKILL); /* end with the thread that started this process */
	prctl(PR_SET_DUMPABLE, 0);        /* other processes of the user cannot trace it */
	if (sandbox_limits(bytes))
		flags |= SCENE_PROTECTION_LIMITS;
	if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0)
		flags |= SCENE_PROTECTION_PRIVILEGES;
	if (sandbox_landlock())
		flags |= SCENE_PROTECTION_LANDLOCK;
	if (sandbox_seccomp())
		flags |= SCENE_PROTECTION_SECCOMP;
	return flags;
}
