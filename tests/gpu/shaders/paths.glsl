/* A function of every kind of branch, for C and for GLSL. `kind` and `bits` are specialization constants there.
 * PATHS_FUNCTION: what stands before functions. */

PATHS_FUNCTION uint paths_early(uint x, uint kind, uint bits)
{
	if ((bits & 1u) != 0u) {
		if (kind == 2u)
			return x + 11u;
		if (x > 20u)
			return x * 3u;
	}
	if (kind == 1u || (bits & 6u) == 6u)
		return x ^ 5u;
	return kind == 3u ? x + 7u : x + 1u;
}

PATHS_FUNCTION uint paths(uint x, uint kind, uint bits)
{
	uint sum = paths_early(x, kind, bits);
	for (uint i = 0u; i < 5u; i++) {
		if ((bits & 8u) != 0u && i == 3u)
			break;
		if ((bits & 16u) != 0u) {
			if ((x & 1u) != 0u)
				continue;
			sum += 100u;
		} else {
			sum += i;
			if (kind > 3u)
				continue;
			sum = sum * 5u + x;
		}
		sum += 2u;
	}
	switch (kind) {
	case 0u:
		if (x > 10u)
			break;
		sum += 1000u;
		break;
	case 1u:
	case 2u:
		sum ^= 77u;
		for (uint i = 0u; i < x; i++) {
			if ((bits & 32u) != 0u)
				break;
			sum += paths_early(i, kind, bits >> 1u);
		}
	/* fall through */
	case 3u:
		sum += 3000u;
		break;
	default:
		if ((bits & 64u) != 0u)
			return sum;
		sum -= 9u;
	}
	for (uint i = 0u; i < 3u; i++) {
		sum = sum * 3u + kind;
		if ((bits & 128u) == 0u)
			break;
		sum += 17u;
	}
	return (bits & 256u) != 0u && x > 30u ? paths_early(sum, kind, bits >> 2u) : sum;
}
