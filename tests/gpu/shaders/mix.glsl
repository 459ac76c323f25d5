/* What a pass of random plans writes: its number and its inputs, mixed as gpu_mix.c does it. */
uint mix_step(uint hash, uint value)
{
	return (hash ^ value) * 16777619u;
}
