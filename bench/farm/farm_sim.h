/*
 * farm_sim: a picture on simulated machines: the engine's own schedule (farm_schedule.h) on clocks that nobody waits
 * for. Speeds, costs of units, latencies and failures come from a seed, so a run repeats exactly.
 *
 * Model.    A machine has cores; a core computes one unit after another. The cost of a unit is lognormal. The host,
 *           which computes too, handles one message after another: a fixed time for each, a time for each unit in it
 *           (taking its sums over), and the bytes through its network. A guest sends its results by farm_flush_is_due,
 *           and both sides look for messages once a millisecond. A machine that fails says nothing any more.
 */
#ifndef FARM_SIM_H
#define FARM_SIM_H

#include <stdint.h>

typedef struct farm_sim_desc {
	uint32_t machines, cores; /* of each */
	uint32_t width, height;   /* of the picture, pixels */
	uint32_t unit;            /* side of a unit, pixels */
	uint32_t samples;         /* a pixel */
	double core_samples_s;    /* samples a second that a core of speed 1 computes */
	double cost_sigma;        /* of the logarithm of a unit's cost; 8 x 8 pixels: larger units vary less */
	double speed_sigma;       /* of the logarithm of a machine's speed; 0: equal machines */
	double failing;           /* share of the guests that fail, at a time spread evenly over the ideal time */
	double latency_s;         /* of a message, one way, and as much again on average by chance */
	double network_bytes_s;   /* of the host */
	double message_s, unit_s; /* the host's time for a message, and for each unit of 8 x 8 pixels in it */
	uint64_t seed;
} farm_sim_desc;

/* 4K with 4,096 samples on machines of 8 cores, 10 Gbit/s, 50 us: farm_sim.c names where the numbers come from. */
farm_sim_desc farm_sim_default(void);

typedef struct farm_sim_result {
	double seconds;    /* until the host has all results */
	double ideal;      /* if all cores of machines that do not fail always computed */
	double efficiency; /* ideal / seconds */
	uint32_t units, twice;
	uint64_t messages;
} farm_sim_result;

farm_sim_result farm_sim_run(const farm_sim_desc *desc);

#endif
