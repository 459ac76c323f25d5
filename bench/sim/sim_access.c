/*
 * What -fsanitize=thread makes the compiler call before accesses to memory, and instead of atomic operations, as of gcc
 * and clang (the interface is that of compiler-rt, lib/tsan/rtl/tsan_interface.h and tsan_interface_atomic.h). Accesses
 * of more than one line do not occur, nor do fences. The operations themselves are sequentially consistent, since one
 * thread runs at a time; an order only decides what an operation costs.
 */
#include "bench/sim/sim.h"

#include <stdatomic.h>

#define CODE __builtin_return_address(0)

void __tsan_init(void);
void __tsan_func_entry(void *caller);
void __tsan_func_exit(void);
void __tsan_read_range(void *at, size_t size);
void __tsan_write_range(void *at, size_t size);

void __tsan_init(void)
{
}

void __tsan_func_entry(void *caller)
{
	(void)caller;
	sim_function();
}

void __sanitizer_cov_trace_pc(void);
void __sanitizer_cov_trace_pc(void)
{
	sim_block();
}

void __tsan_func_exit(void)
{
}

void __tsan_read_range(void *at, size_t size)
{
	for (size_t i = 0; i < size; i += 64)
		sim_read((char *)at + i, CODE);
}

void __tsan_write_range(void *at, size_t size)
{
	for (size_t i = 0; i < size; i += 64)
		sim_write((char *)at + i, CODE);
}

#define PLAIN(size)                                                                                                    \
	void __tsan_read##size(void *at);                                                                                  \
	void __tsan_write##size(void *at);                                                                                 \
	void __tsan_unaligned_read##size(void *at);                                                                        \
	void __tsan_unaligned_write##size(void *at);                                                                       \
	void __tsan_read##size(void *at)                                                                                   \
	{                                                                                                                  \
		sim_read(at, CODE);                                                                                            \
	}                                                                                                                  \
	void __tsan_write##size(void *at)                                                                                  \
	{                                                                                                                  \
		sim_write(at, CODE);                                                                                           \
	}                                                                                                                  \
	void __tsan_unaligned_read##size(void *at)                                                                         \
	{                                                                                                                  \
		sim_read(at, CODE);                                                                                            \
	}                                                                                                                  \
	void __tsan_unaligned_write##size(void *at)                                                                        \
	{                                                                                                                  \
		sim_write(at, CODE);                                                                                           \
	}
PLAIN(1)
PLAIN(2)
PLAIN(4)
PLAIN(8)
PLAIN(16)

/* An operation that replaces *at, called `old`, by `result`. */
#define RMW(bits, name, result)                                                                                        \
	uint##bits##_t __tsan_atomic##bits##_##name(volatile uint##bits##_t *at, uint##bits##_t value, int order);         \
	uint##bits##_t __tsan_atomic##bits##_##name(volatile uint##bits##_t *at, uint##bits##_t value, int order)          \
	{                                                                                                                  \
		(void)order;                                                                                                   \
		sim_rmw(at, CODE);                                                                                             \
		uint##bits##_t old = *at;                                                                                      \
		*at = (uint##bits##_t)(result);                                                                                \
		return old;                                                                                                    \
	}
#define COMPARE(bits, name)                                                                                            \
	int __tsan_atomic##bits##_compare_exchange_##name(volatile uint##bits##_t *at, uint##bits##_t *expected,           \
	                                                  uint##bits##_t value, int order, int failure);                   \
	int __tsan_atomic##bits##_compare_exchange_##name(volatile uint##bits##_t *at, uint##bits##_t *expected,           \
	                                                  uint##bits##_t value, int order, int failure)                    \
	{                                                                                                                  \
		(void)order, (void)failure;                                                                                    \
		sim_rmw(at, CODE);                                                                                             \
		if (*at == *expected) {                                                                                        \
			*at = value;                                                                                               \
			return 1;                                                                                                  \
		}                                                                                                              \
		*expected = *at;                                                                                               \
		return 0;                                                                                                      \
	}
#define ATOMIC(bits)                                                                                                   \
	uint##bits##_t __tsan_atomic##bits##_load(const volatile uint##bits##_t *at, int order);                           \
	void __tsan_atomic##bits##_store(volatile uint##bits##_t *at, uint##bits##_t value, int order);                    \
	uint##bits##_t __tsan_atomic##bits##_compare_exchange_val(volatile uint##bits##_t *at, uint##bits##_t expected,    \
	                                                          uint##bits##_t value, int order, int failure);           \
	uint##bits##_t __tsan_atomic##bits##_load(const volatile uint##bits##_t *at, int order)                            \
	{                                                                                                                  \
		(void)order;                                                                                                   \
		sim_read(at, CODE);                                                                                            \
		return *at;                                                                                                    \
	}                                                                                                                  \
	void __tsan_atomic##bits##_store(volatile uint##bits##_t *at, uint##bits##_t value, int order)                     \
	{                                                                                                                  \
		if (order == memory_order_seq_cst)                                                                             \
			sim_rmw(at, CODE);                                                                                         \
		else                                                                                                           \
			sim_write(at, CODE);                                                                                       \
		*at = value;                                                                                                   \
	}                                                                                                                  \
	uint##bits##_t __tsan_atomic##bits##_compare_exchange_val(volatile uint##bits##_t *at, uint##bits##_t expected,    \
	                                                          uint##bits##_t value, int order, int failure)            \
	{                                                                                                                  \
		(void)order, (void)failure;                                                                                    \
		sim_rmw(at, CODE);                                                                                             \
		uint##bits##_t old = *at;                                                                                      \
		if (old == expected)                                                                                           \
			*at = value;                                                                                               \
		return old;                                                                                                    \
	}                                                                                                                  \
	COMPARE(bits, strong)                                                                                              \
	COMPARE(bits, weak)                                                                                                \
	RMW(bits, exchange, value)                                                                                         \
	RMW(bits, fetch_add, old + value)                                                                                  \
	RMW(bits, fetch_sub, old - value)                                                                                  \
	RMW(bits, fetch_or, old | value)                                                                                   \
	RMW(bits, fetch_and, old &value)                                                                                   \
	RMW(bits, fetch_xor, old ^ value)
ATOMIC(8)
ATOMIC(16)
ATOMIC(32)
ATOMIC(64)
