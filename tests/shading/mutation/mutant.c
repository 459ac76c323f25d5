#include "mutant.h"

#include <stdio.h>
#include <stdlib.h>

int shade_mutant_chosen = -1;
float shade_mutant_factor = 1.0f;
unsigned char shade_mutants_seen[SHADE_MUTANT_COUNT];

/* Before the tables of the headers are filled: those constructors have no priority, which is later. */
static __attribute__((constructor(101))) void mutant_choose(void)
{
	const char *change = getenv("STILB_MUTANT");
	if (change && sscanf(change, "%d %f", &shade_mutant_chosen, &shade_mutant_factor) != 2)
		abort();
}

static __attribute__((destructor)) void mutant_report(void)
{
	const char *path = getenv("STILB_MUTANTS_SEEN");
	FILE *file = path ? fopen(path, "w") : NULL;
	if (!file)
		return;
	for (int id = 0; id < SHADE_MUTANT_COUNT; id++)
		if (shade_mutants_seen[id])
			fprintf(file, "%d\n", id);
	fclose(file);
}
