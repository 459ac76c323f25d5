/* What a test of shade_planted.h might look like that proves some of its literals. */
#include "shade_planted.h"

static int near(float got, float want, float relative)
{
	return fabsf(got - want) <= relative * want;
}

int main(void)
{
	int good = near(shade_planted_proved(0.5f), 3.0f, 1e-4f); /* 3 x + 1 + x */
	good &= near(shade_planted_loose(2.0f), 10.0f, 0.1f);
	good &= near(SHADE_PLANTED_TABLE[0], 0.25f, 1e-4f) && near(SHADE_PLANTED_TABLE[1], 0.5f, 1e-4f);
	return !good;
}
