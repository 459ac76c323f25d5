/* Stress test: pads are plugged in and unplugged at every moment of a program that reads them. The subjects are
 * processes: the engine with either backend, and a loop of hid_enumerate of hidapi 0.13.1. A crash is counted and the
 * subject started again. Runs in the virtual machine of boot.sh.
 *
 * The engine with hidraw must not crash. With hidapi it may, very rarely: hid_open_path uses freed memory if the pad is
 * unplugged between its first two system calls (measured: 1 crash in 3,000 cycles), which no caller can prevent.
 *
 * test_vm_storm CYCLES SUBJECT-PROGRAM */
#include "support/test.h"
#include "vm/vm_ds4.h"
#include "vm/vm_fixture.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

static uint32_t cycles;
static const char *program;

typedef struct subject {
	const char *kind;
	pid_t pid;
	int input, output; /* this program's ends of the pipes to the subject's standard input and output */
	uint32_t crashes;
	int last_signal;
	unsigned long long added, removed, reports; /* of enumerate: enumerations that found a pad */
	int descriptors, threads;                   /* open descriptors and threads at its end, less those at its start */
} subject;

static void subject_start(subject *who)
{
	int to[2], from[2];
	assert_int_equal(pipe2(to, O_CLOEXEC), 0);
	assert_int_equal(pipe2(from, O_CLOEXEC), 0);
	who->pid = fork();
	assert_true(who->pid >= 0);
	if (who->pid == 0) {
		dup2(to[0], STDIN_FILENO);
		dup2(from[1], STDOUT_FILENO);
		execl(program, program, who->kind, NULL);
		_exit(127);
	}
	close(to[0]);
	close(from[1]);
	who->input = to[1];
	who->output = from[0];
	char ready[6]; /* "ready\n"; nothing comes if the subject crashes at once */
	ssize_t size = read(who->output, ready, sizeof ready);
	assert_true(size == 0 || size == sizeof ready);
}

/* To be called when a subject's process has ended with this status: reads its counts if it ended normally, else counts
 * a crash. */
static void subject_ended(subject *who, int status)
{
	char said[128] = "";
	ssize_t size = read(who->output, said, sizeof said - 1);
	close(who->output);
	if (WIFSIGNALED(status)) {
		who->crashes++;
		who->last_signal = WTERMSIG(status);
		return;
	}
	assert_int_equal(status, 0);
	assert_true(size > 0);
	assert_int_equal(sscanf(said, "%llu %llu %llu %d %d", &who->added, &who->removed, &who->reports, &who->descriptors,
	                        &who->threads),
	                 5);
}

static void subject_restart_if_crashed(subject *who)
{
	int status;
	if (waitpid(who->pid, &status, WNOHANG) != who->pid)
		return;
	close(who->input);
	assert_true(WIFSIGNALED(status)); /* a crash, as the subject was not told to end */
	subject_ended(who, status);
	subject_start(who);
}

static void subject_finish(subject *who)
{
	int status;
	close(who->input);
	assert_int_equal(waitpid(who->pid, &status, 0), who->pid);
	subject_ended(who, status);
}

/* Plugs a pad in and out again: in some cycles it is there for a moment, in others for as long as opening and
 * enumerating take; it sends reports all the time. */
static void plug_and_pull(const input_test_descriptor *kind, uint32_t cycle)
{
	uint8_t report[VM_DS4_USB_BYTES];
	uhid_pad *pad = uhid_pad_create(kind, "storm");
	int64_t lives_us = (int64_t)(stilb_random_float(1, cycle) * 24000);
	for (int64_t end = vm_now_us() + lives_us; vm_now_us() < end; vm_sleep_until_us(vm_now_us() + 2000))
		uhid_pad_send(pad, report, vm_ds4_usb(cycle, 128, report));
	uhid_pad_destroy(pad);
}

static void test_storm(void **state)
{
	(void)state;
	subject subjects[] = {{.kind = "hidraw"}, {.kind = "hidapi"}, {.kind = "enumerate"}};
	enum { OURS = 2, ALL = 3 };
	const input_test_descriptor *kind = input_test_descriptor_find(STILB_INPUT_BUS_USB, 0x054c, 0x05c4);
	vm_module_set("hid", "ignore_special_drivers", "1");
	for (int i = 0; i < ALL; i++)
		subject_start(&subjects[i]);
	int64_t start = vm_now_us();
	for (uint32_t cycle = 0; cycle < cycles; cycle++) {
		plug_and_pull(kind, cycle);
		for (int i = 0; i < ALL; i++)
			subject_restart_if_crashed(&subjects[i]);
	}
	printf("  %u cycles in %.1f s\n", cycles, (double)(vm_now_us() - start) / 1e6);
	for (int i = 0; i < ALL; i++) {
		subject *who = &subjects[i];
		subject_finish(who);
		printf("  %-9s %u crashes%s%s", who->kind, who->crashes, who->crashes ? ", the last by " : "",
		       who->crashes ? strsignal(who->last_signal) : "");
		if (i < OURS)
			printf("; %llu pads came, %llu went, %llu reports, %d descriptors and %d threads left over", who->added,
			       who->removed, who->reports, who->descriptors, who->threads);
		else
			printf("; %llu enumerations since, %llu with something in sight", who->removed, who->added);
		printf("\n");
	}
	assert_int_equal(subjects[0].crashes, 0);
	assert_true(subjects[1].crashes <= 1 + cycles / 500);
	for (int i = 0; i < OURS; i++) {
		assert_true(subjects[i].crashes > 0 ||
		            subjects[i].added > cycles / 8); /* others are gone before they are found */
		assert_int_equal(subjects[i].added, subjects[i].removed);
		assert_int_equal(subjects[i].descriptors, 0);
		assert_int_equal(subjects[i].threads, 0);
	}
}

int main(int argc, char **argv)
{
	if (argc != 3) {
		fprintf(stderr, "usage: test_vm_storm CYCLES SUBJECT-PROGRAM\n");
		return 2;
	}
	cycles = (uint32_t)strtoul(argv[1], NULL, 10);
	program = argv[2];
	setvbuf(stdout, NULL, _IOLBF, 0);
	static const struct CMUnitTest tests[] = {cmocka_unit_test(test_storm)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
