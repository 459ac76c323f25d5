#include "bench/sim/sim.h"

/*
 * Transfers of lines: medians of the measurements collected at github.com/nviennot/core-to-core-latency (results/, read
 * at commit 96a943a, January 2023): one message from a core to another by a compare-exchange. The medians were taken
 * over the pairs of CPUs at the same distance: Dual Platinum 8375C (two threads of a core, one socket, two sockets),
 * Dual EPYC 7742 (thread, 4 cores with one cache, socket, two sockets), Graviton3 (one socket of 64 cores).
 * The Graviton3 has one socket; its distance to another one is an assumption, the 8375C's ratio.
 * Read-modify-writes: 18 cycles (Agner Fog, instruction tables: LOCK XADD on Ice Lake and Zen 2). Pause: 140 cycles
 * (Intel, optimization manual, since Skylake), 65 on Zen 2 (Agner Fog). The Graviton3's are assumptions.
 * The kernel's costs of all are those measured here, on two CPUs of a virtual machine (AMD EPYC, family 25 model 17,
 * Linux, sleeps of 120 us): medians of 2,000 wakes. Published latencies of Ice Lake and Skylake Xeons of their own are
 * 12 to 21 us (reported with a patch by I. Nechita for Linux's menu governor).
 * Instructions: a basic block and a function call cost here what suits the rows of one thread best (docs/jobs.md);
 * the three machines' cores are taken to be 1.6 times as slow, which is what the look for work has cost on a Xeon of
 * 2.5 GHz.
 */
#define KERNEL .call = 280, .wake = 7000, .latency = 20000, .sleep = 1500, .create = 15000, .timeslice = 3000000

const sim_machine sim_machines[] = {
	{.name = "xeon",
     .title = "2 Intel Xeon Platinum 8375C (Ice Lake)",
     .cores = 32,
     .sockets = 2,
     .threads = 2,
     .cluster = 32,
     .smt = 8.0,
     .near = 51.3,
     .socket = 51.3,
     .far = 105.4,
     .rmw = 5.5,
     .pause = 44,
     .block = 0.21,
     .function = 1.1,
     KERNEL},
	{.name = "epyc",
     .title = "2 AMD EPYC 7742 (Rome)",
     .cores = 64,
     .sockets = 2,
     .threads = 2,
     .cluster = 4,
     .smt = 8.0,
     .near = 25.3,
     .socket = 141,
     .far = 261,
     .rmw = 5.5,
     .pause = 20,
     .block = 0.21,
     .function = 1.1,
     KERNEL},
	{.name = "graviton",
     .title = "AWS Graviton3 (Neoverse V1)",
     .cores = 64,
     .sockets = 1,
     .threads = 1,
     .cluster = 64,
     .smt = 46.4,
     .near = 46.4,
     .socket = 46.4,
     .far = 95,
     .rmw = 5.5,
     .pause = 10,
     .block = 0.21,
     .function = 1.1,
     KERNEL},
	{.name = "here",
     .title = "the machine of docs/jobs.md: 2 CPUs of an AMD EPYC (Zen 4), virtual",
     .cores = 2,
     .sockets = 1,
     .threads = 1,
     .cluster = 2,
     .smt = 83,
     .near = 83,
     .socket = 83,
     .far = 83,
     .rmw = 2.3,
     .pause = 26,
     .block = 0.13,
     .function = 0.7,
     KERNEL},
};
const size_t sim_machine_count = sizeof sim_machines / sizeof *sim_machines;
