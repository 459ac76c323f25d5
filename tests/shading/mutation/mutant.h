/*
 * mutant: the run-time half of mutants.awk, included before everything else into a test built with changed headers.
 *
 * STILB_MUTANT="ID FACTOR" in the environment multiplies the literal with this number. STILB_MUTANTS_SEEN=FILE writes
 * the numbers of all literals that the run came across, one per line, when the program ends.
 */
#ifndef SHADE_MUTANT_H
#define SHADE_MUTANT_H

#define SHADE_MUTANT_COUNT 4096 /* more literals than the headers have: mutate.sh checks it */

extern int shade_mutant_chosen;
extern float shade_mutant_factor;
extern unsigned char shade_mutants_seen[SHADE_MUTANT_COUNT];

static inline float shade_mutant(int id, float literal)
{
	shade_mutants_seen[id] = 1;
	return id == shade_mutant_chosen ? shade_mutant_factor * literal : literal;
}

#endif
