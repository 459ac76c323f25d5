/* gpu: shaders without the code that their specialization constants never reach. Constants are propagated
 * through the blocks that can be reached (Wegman, Zadeck 1991: sparse conditional constant propagation, here walks in
 * reverse postorder that take what loops carry as unknown), then what is left is written with its structure intact
 * (Khronos, SPIR-V Specification 1.6, section 2.11: structured control flow). */
#include "gpu/spirv/gpu_specialize.h"

#include "gpu/spirv/gpu_spirv_words.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

typedef enum module_type { MODULE_TYPE_OTHER, MODULE_TYPE_BOOL, MODULE_TYPE_INT /* of 32 bits */ } module_type;

typedef struct module_id {
	uint8_t type; /* module_type, of a type */
	bool known;   /* a truth value or an integer of 32 bits that is always `value` */
	bool narrow;  /* an integer of 32 bits */
	bool given;   /* a specialization constant: the program gives it `value` */
	bool stays;   /* it is defined in what is written */
	bool goes;    /* it is defined in a block that is left out */
	bool fixed;   /* known without any block: a constant */
	bool exit;    /* of a label: a merge instruction names it */
	uint32_t value;
	uint32_t block; /* + 1, of a label */
} module_id;

typedef enum block_stub { BLOCK_STUB_NONE, BLOCK_STUB_UNREACHABLE, BLOCK_STUB_CONTINUE } block_stub;

/* A block of a function. Places are words of the module, labels are ids; 0: none. */
typedef struct module_block {
	uint32_t label;
	uint32_t first, end; /* its OpLabel, and behind its last instruction */
	uint32_t last;       /* that instruction: where the block goes */
	uint32_t merge;      /* the merge instruction right before it: the block is the header of a construct */
	uint32_t taken;      /* the label of the one block to which it goes though its last instruction has others */
	uint32_t rank;       /* in reverse postorder, from 1; 0: no path leads here */
	uint32_t inside;     /* the label of the header of the innermost construct around it */
	uint32_t loop;       /* of BLOCK_STUB_CONTINUE: the label of the loop's header */
	bool entry;          /* the first of its function */
	bool live;           /* reached, as far as is known in this round */
	bool was_live;       /* reached in the round before */
	bool whole;          /* it goes where it always did: the structure would not survive otherwise */
	uint8_t stub;        /* block_stub: not reached, but a merge instruction that stays names it */
} module_block;

typedef struct module {
	const uint32_t *words;
	uint32_t count, bound;
	uint32_t body; /* where the first function begins */
	module_id *ids;
	module_block *blocks;
	uint32_t block_count, block_room;
	module_block **order; /* blocks that a path leads to; each function's in reverse postorder */
	uint32_t order_count;
	uint32_t *out;
	uint32_t out_count;
} module;

static uint32_t op_at(const module *m, uint32_t at)
{
	return m->words[at] & 0xffffu;
}

static uint32_t length_at(const module *m, uint32_t at)
{
	return m->words[at] >> 16;
}

/* Where an instruction of a function names its result: 0 if it has none. */
static uint32_t result_place(uint32_t op)
{
	switch (op) {
	case OP_LABEL:
		return 1;
	case OP_NOP:
	case OP_LINE:
	case OP_NO_LINE:
	case OP_IMAGE_WRITE:
	case OP_ATOMIC_STORE:
	case OP_FUNCTION_END:
	case OP_TERMINATE_INVOCATION:
	case OP_DEMOTE_TO_HELPER_INVOCATION:
		return 0;
	default:
		return (op >= OP_STORE && op <= OP_COPY_MEMORY_SIZED) || (op >= OP_EMIT_VERTEX && op <= OP_MEMORY_BARRIER) ||
		               (op >= OP_LOOP_MERGE && op <= OP_LIFETIME_STOP)
		           ? 0
		           : 2;
	}
}

static bool is_end_of_block(uint32_t op)
{
	return (op >= OP_BRANCH && op <= OP_UNREACHABLE) || op == OP_TERMINATE_INVOCATION;
}

static module_block *block_of(const module *m, uint32_t label)
{
	return label < m->bound && m->ids[label].block > 0 ? &m->blocks[m->ids[label].block - 1] : NULL;
}

/* How many labels a block's last instruction has, and the label `i` of them; 0: there are not so many. */
static uint32_t successor_count(const module *m, const module_block *block)
{
	switch (op_at(m, block->last)) {
	case OP_BRANCH:
		return 1;
	case OP_BRANCH_CONDITIONAL:
		return 2;
	case OP_SWITCH:
		return (length_at(m, block->last) - 1) / 2;
	default:
		return 0;
	}
}

static uint32_t successor(const module *m, const module_block *block, uint32_t i)
{
	const uint32_t *words = &m->words[block->last];
	if (i >= successor_count(m, block))
		return 0;
	switch (op_at(m, block->last)) {
	case OP_BRANCH:
		return words[1];
	case OP_BRANCH_CONDITIONAL:
		return words[2 + i];
	default:
		return words[2 + 2 * i];
	}
}

/* ---- what is known ----------------------------------------------------------------------------------------------- */

/* What an operation on two known operands gives; false: it is none of these. */
static bool folded_pair(uint32_t op, uint32_t a, uint32_t b, uint32_t *value)
{
	bool narrow = b < 32;
	switch (op) {
	case OP_I_ADD:
		*value = a + b;
		return true;
	case OP_I_SUB:
		*value = a - b;
		return true;
	case OP_I_MUL:
		*value = a * b;
		return true;
	case OP_BITWISE_OR:
		*value = a | b;
		return true;
	case OP_BITWISE_XOR:
		*value = a ^ b;
		return true;
	case OP_SHIFT_LEFT_LOGICAL:
		*value = narrow ? a << b : 0;
		return narrow;
	case OP_SHIFT_RIGHT_LOGICAL:
		*value = narrow ? a >> b : 0;
		return narrow;
	default:
		return false;
	}
}

/* The same for comparisons. */
static bool compared(uint32_t op, uint32_t a, uint32_t b, uint32_t *value)
{
	switch (op) {
	case OP_LOGICAL_EQUAL:
	case OP_I_EQUAL:
		*value = a == b;
		return true;
	case OP_LOGICAL_NOT_EQUAL:
	case OP_I_NOT_EQUAL:
		*value = a != b;
		return true;
	case OP_U_GREATER_THAN:
	case OP_U_LESS_THAN_EQUAL:
		*value = (a > b) == (op == OP_U_GREATER_THAN);
		return true;
	case OP_U_LESS_THAN:
	case OP_U_GREATER_THAN_EQUAL:
		*value = (a < b) == (op == OP_U_LESS_THAN);
		return true;
	case OP_S_GREATER_THAN:
	case OP_S_LESS_THAN_EQUAL:
		*value = ((int32_t)a > (int32_t)b) == (op == OP_S_GREATER_THAN);
		return true;
	case OP_S_LESS_THAN:
	case OP_S_GREATER_THAN_EQUAL:
		*value = ((int32_t)a < (int32_t)b) == (op == OP_S_LESS_THAN);
		return true;
	default:
		return false;
	}
}

/* True if the operation has a value that follows from what is known of its operands; *value then is that value. */
static bool folded(const module *m, uint32_t op, const uint32_t *operands, uint32_t count, uint32_t *value)
{
	if (count == 0 || count > 3)
		return false;
	bool known[3] = {false};
	uint32_t v[3] = {0};
	for (uint32_t i = 0; i < count; i++) {
		if (operands[i] >= m->bound)
			return false;
		known[i] = m->ids[operands[i]].known;
		v[i] = known[i] ? m->ids[operands[i]].value : 0;
	}
	bool both = known[0] && known[1];
	switch (op) { /* where one operand may decide */
	case OP_LOGICAL_OR:
		*value = v[0] || v[1];
		return *value || both;
	case OP_LOGICAL_AND:
		*value = v[0] && v[1];
		return both || (known[0] && !v[0]) || (known[1] && !v[1]);
	case OP_BITWISE_AND:
		*value = v[0] & v[1];
		return both || (known[0] && !v[0]) || (known[1] && !v[1]);
	case OP_SELECT:
		*value = v[0] ? v[1] : v[2];
		return count == 3 && known[0] && known[v[0] ? 1 : 2];
	case OP_NOT:
	case OP_LOGICAL_NOT:
		*value = op == OP_NOT ? ~v[0] : !v[0];
		return known[0];
	case OP_COPY_OBJECT:
	case OP_BITCAST:
		*value = v[0];
		return known[0];
	default:
		return count == 2 && both && (folded_pair(op, v[0], v[1], value) || compared(op, v[0], v[1], value));
	}
}

/* Whether a block's last instruction, as it will be written, leads to a label. */
static bool leads_to(const module *m, const module_block *block, uint32_t label)
{
	if (block->taken > 0)
		return block->taken == label;
	for (uint32_t i = 0, next; (next = successor(m, block, i)) > 0; i++)
		if (next == label)
			return true;
	return false;
}

/* Whether control comes from a block to another, as far as this round knows. Of blocks that loop back it knows what the
 * round before found. */
static bool comes_from(const module *m, const module_block *from, const module_block *to)
{
	if (from->rank == 0)
		return false;
	return from->rank < to->rank ? from->live && leads_to(m, from, to->label) : from->was_live;
}

/* A phi is known where all values that can come are the same. */
static bool folded_phi(const module *m, const module_block *block, uint32_t at, uint32_t *value)
{
	bool some = false;
	for (uint32_t i = 3; i + 1 < length_at(m, at); i += 2) {
		const module_block *from = block_of(m, m->words[at + i + 1]);
		if (!from || !comes_from(m, from, block))
			continue;
		const module_id *id = &m->ids[m->words[at + i]];
		if (!id->known || (some && id->value != *value))
			return false;
		some = true;
		*value = id->value;
	}
	return some;
}

static void evaluate(module *m, const module_block *block, uint32_t at)
{
	uint32_t op = op_at(m, at), length = length_at(m, at);
	if (result_place(op) != 2 || length < 4 || m->ids[m->words[at + 1]].type == MODULE_TYPE_OTHER)
		return;
	module_id *id = &m->ids[m->words[at + 2]];
	uint32_t value;
	if (op == OP_PHI ? folded_phi(m, block, at, &value) : folded(m, op, &m->words[at + 3], length - 3, &value)) {
		id->known = true;
		id->value = value;
	}
}

/* The label that a branch takes by what is known; 0: it may take several. */
static uint32_t taken_branch(const module *m, const module_block *block)
{
	const uint32_t *words = &m->words[block->last];
	uint32_t op = op_at(m, block->last), length = length_at(m, block->last);
	if ((op != OP_BRANCH_CONDITIONAL && op != OP_SWITCH) || !m->ids[words[1]].known)
		return 0;
	uint32_t value = m->ids[words[1]].value;
	if (op == OP_BRANCH_CONDITIONAL)
		return words[value ? 2 : 3];
	for (uint32_t i = 3; i + 1 < length; i += 2)
		if (words[i] == value)
			return words[i + 1];
	return words[2];
}

/* Decides where a block goes. Branches that loop back stay, as each loop must have one. A switch stays one with a
 * single case, as its blocks may leave it from within other constructs; a case that leaves an outer construct would not
 * be one. */
static uint32_t decided(const module *m, const module_block *block)
{
	uint32_t taken = block->whole ? 0 : taken_branch(m, block);
	if (taken == 0)
		return 0;
	for (uint32_t i = 0, next; (next = successor(m, block, i)) > 0; i++)
		if (block_of(m, next)->rank <= block->rank)
			return 0;
	bool leaves = m->ids[taken].exit && (block->merge == 0 || taken != m->words[block->merge + 1]);
	return op_at(m, block->last) == OP_SWITCH && leaves ? 0 : taken;
}

/* One walk over all blocks that can be reached. Returns their number. */
static uint32_t propagate(module *m)
{
	uint32_t live = 0;
	for (uint32_t i = 0; i < m->order_count; i++) {
		m->order[i]->was_live = m->order[i]->live;
		m->order[i]->live = m->order[i]->entry;
		m->order[i]->taken = 0;
	}
	for (uint32_t i = 0; i < m->order_count; i++) {
		module_block *block = m->order[i];
		if (!block->live)
			continue;
		live++;
		for (uint32_t at = block->first; at < block->last; at += length_at(m, at))
			evaluate(m, block, at);
		block->taken = decided(m, block);
		for (uint32_t s = 0, next; (next = successor(m, block, s)) > 0; s++) {
			module_block *to = block_of(m, next);
			to->live |= leads_to(m, block, next);
		}
	}
	return live;
}

/* ---- structure --------------------------------------------------------------------------------------------------- */

static bool has_merge(const module *m, const module_block *block, uint32_t op)
{
	return block->merge > 0 && op_at(m, block->merge) == op;
}

/* A selection of which one side is left is none: its merge instruction goes. */
static bool is_dissolved(const module *m, const module_block *block)
{
	return block->taken > 0 && has_merge(m, block, OP_SELECTION_MERGE) &&
	       op_at(m, block->last) == OP_BRANCH_CONDITIONAL;
}

/* The label of the innermost construct around a block that is still one. */
static uint32_t construct_of(const module *m, const module_block *block)
{
	uint32_t label = block->inside;
	for (const module_block *header = block_of(m, label); header && is_dissolved(m, header);
	     header = block_of(m, label))
		label = header->inside;
	return label;
}

/* True if no block leaves the selection from within another construct: that would be no structured exit any more. */
static bool dissolves(const module *m, const module_block *header)
{
	uint32_t merge = m->words[header->merge + 1];
	uint32_t around = construct_of(m, header);
	for (uint32_t i = 0; i < m->order_count; i++) {
		const module_block *from = m->order[i];
		if (!from->live || from == header || !leads_to(m, from, merge))
			continue;
		bool heads = from->merge > 0 && !is_dissolved(m, from);
		if (heads || construct_of(m, from) != around)
			return false;
	}
	return true;
}

/* Marks the selections that have to stay whole. False: there was one. Inner ones come first, as they may dissolve. */
static bool structure_holds(module *m)
{
	bool holds = true;
	for (uint32_t i = m->order_count; i > 0; i--) {
		module_block *header = m->order[i - 1];
		if (header->live && is_dissolved(m, header) && !dissolves(m, header)) {
			header->whole = true;
			holds = false;
		}
	}
	return holds;
}

/* True if a path leads to the block, and not only behind the other. */
static bool is_before(const module_block *block, const module_block *other)
{
	return block->rank > 0 && block->rank <= other->rank;
}

/* The innermost construct around each block: a merge block lies where its header does, any other where a block lies
 * that leads to it, or in the construct that this one heads. Blocks that leave constructs lead to merge blocks and
 * continue targets alone. False: a merge instruction names a block before its own, so that constructs would not end. */
static bool nest(module *m)
{
	for (uint32_t i = 0; i < m->order_count; i++) {
		const module_block *block = m->order[i];
		for (uint32_t s = 0, next; (next = successor(m, block, s)) > 0; s++) {
			module_block *to = block_of(m, next);
			if (to->rank > block->rank && !m->ids[next].exit)
				to->inside = block->merge > 0 ? block->label : block->inside;
		}
		if (block->merge == 0)
			continue;
		module_block *after = block_of(m, m->words[block->merge + 1]);
		module_block *back = has_merge(m, block, OP_LOOP_MERGE) ? block_of(m, m->words[block->merge + 2]) : after;
		if (is_before(after, block) || (is_before(back, block) && back != block))
			return false;
		if (back != after && back != block)
			back->inside = block->label;
		after->inside = block->inside;
	}
	return true;
}

/* Gives the blocks that merge instructions name though nothing leads to them something to do. False: a loop would go
 * back from nowhere. */
static bool add_stubs(module *m)
{
	for (uint32_t i = 0; i < m->order_count; i++) {
		const module_block *header = m->order[i];
		if (!header->live || header->merge == 0 || is_dissolved(m, header))
			continue;
		module_block *after = block_of(m, m->words[header->merge + 1]);
		if (!after->live && after->stub == BLOCK_STUB_NONE)
			after->stub = BLOCK_STUB_UNREACHABLE;
		if (!has_merge(m, header, OP_LOOP_MERGE))
			continue;
		module_block *back = block_of(m, m->words[header->merge + 2]);
		if (!back->live) {
			back->stub = BLOCK_STUB_CONTINUE;
			back->loop = header->label;
			continue;
		}
		bool loops = false;
		for (uint32_t b = i; b < m->order_count; b++)
			loops |= m->order[b]->live && leads_to(m, m->order[b], header->label);
		if (!loops)
			return false;
	}
	return true;
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

/* A declaration before the functions. */
static bool read_declaration(module *m, uint32_t at, const stilb_gpu_program_desc *desc)
{
	const uint32_t *words = &m->words[at];
	uint32_t op = op_at(m, at), length = length_at(m, at), value;
	module_id *id = length > 2 && words[2] < m->bound ? &m->ids[words[2]] : NULL;
	switch (op) {
	case OP_DECORATE:
		if (length > 3 && words[1] < m->bound && words[2] == DECORATION_SPEC_ID)
			for (uint32_t c = 0; c < desc->constant_count; c++)
				if (desc->constants[c].id == words[3]) {
					m->ids[words[1]].given = true;
					m->ids[words[1]].value = desc->constants[c].value;
				}
		return true;
	case OP_TYPE_BOOL:
	case OP_TYPE_INT:
		if (length < 2 || words[1] >= m->bound || (op == OP_TYPE_INT && length < 4))
			return false;
		if (op == OP_TYPE_BOOL || words[2] == 32)
			m->ids[words[1]].type = op == OP_TYPE_BOOL ? MODULE_TYPE_BOOL : MODULE_TYPE_INT;
		return true;
	case OP_CONSTANT_TRUE:
	case OP_CONSTANT_FALSE:
	case OP_CONSTANT:
	case OP_SPEC_CONSTANT_TRUE:
	case OP_SPEC_CONSTANT_FALSE:
	case OP_SPEC_CONSTANT:
		if (!id || words[1] >= m->bound || ((op == OP_CONSTANT || op == OP_SPEC_CONSTANT) && length < 4))
			return false;
		value = op == OP_CONSTANT || op == OP_SPEC_CONSTANT ? words[3]
		                                                    : op == OP_CONSTANT_TRUE || op == OP_SPEC_CONSTANT_TRUE;
		id->narrow = m->ids[words[1]].type == MODULE_TYPE_INT;
		id->known = id->fixed = m->ids[words[1]].type != MODULE_TYPE_OTHER;
		id->value = id->given ? id->value : value;
		if (m->ids[words[1]].type == MODULE_TYPE_BOOL)
			id->value = id->value != 0;
		return true;
	case OP_SPEC_CONSTANT_OP:
		if (!id || length < 4 || words[1] >= m->bound)
			return false;
		if (m->ids[words[1]].type != MODULE_TYPE_OTHER && folded(m, words[3], &words[4], length - 4, &value)) {
			id->known = id->fixed = true;
			id->value = value;
		}
		return true;
	default:
		return true;
	}
}

/* Begins a block at an OpLabel. */
static bool read_label(module *m, uint32_t at, bool entry)
{
	uint32_t label = m->words[at + 1];
	if (length_at(m, at) != 2 || label >= m->bound || m->ids[label].block > 0)
		return false;
	if (m->block_count == m->block_room) {
		uint32_t room = m->block_room ? m->block_room * 2 : 256;
		module_block *grown = realloc(m->blocks, room * sizeof *grown);
		if (!grown)
			return false;
		m->blocks = grown;
		m->block_room = room;
	}
	m->blocks[m->block_count++] = (module_block){.label = label, .first = at, .entry = entry};
	m->ids[label].block = m->block_count;
	return true;
}

/* An instruction of a function. *in_block: it lies between an OpLabel and the block's last instruction. *entry: the
 * next block is the function's first. */
static bool read_instruction(module *m, uint32_t at, bool *in_block, bool *entry)
{
	uint32_t op = op_at(m, at), length = length_at(m, at), place = result_place(op);
	if (op == OP_FUNCTION) {
		*entry = true;
		return !*in_block;
	}
	if (op == OP_LABEL) {
		bool good = !*in_block && length > 1 && read_label(m, at, *entry);
		*in_block = true;
		*entry = false;
		return good;
	}
	if (!*in_block)
		return true;
	module_block *block = &m->blocks[m->block_count - 1];
	if (place > 0 && (length <= place || m->words[at + place] >= m->bound || m->words[at + 1] >= m->bound))
		return false;
	if (place == 2)
		m->ids[m->words[at + 2]].narrow = m->ids[m->words[at + 1]].type == MODULE_TYPE_INT;
	if (op == OP_PHI)
		for (uint32_t i = 3; i < length; i++)
			if (m->words[at + i] >= m->bound)
				return false;
	if (op == OP_LOOP_MERGE || op == OP_SELECTION_MERGE) {
		block->merge = at;
		return length >= (op == OP_LOOP_MERGE ? 4 : 3);
	}
	if (is_end_of_block(op)) {
		block->last = at;
		block->end = at + length;
		*in_block = false;
		return !block->merge || block->merge + length_at(m, block->merge) == at;
	}
	return true;
}

static bool is_label(const module *m, uint32_t id)
{
	return block_of(m, id);
}

/* True if blocks go to blocks, and merge instructions name some. */
static bool labels_exist(module *m)
{
	for (uint32_t b = 0; b < m->block_count; b++) {
		const module_block *block = &m->blocks[b];
		uint32_t op = op_at(m, block->last), length = length_at(m, block->last);
		uint32_t least = op == OP_SWITCH ? 3 : op == OP_BRANCH_CONDITIONAL ? 4 : op == OP_BRANCH ? 2 : 1;
		if (length < least ||
		    ((op == OP_SWITCH || op == OP_BRANCH_CONDITIONAL) && m->words[block->last + 1] >= m->bound))
			return false;
		/* Numbers of 64 bits take two words. */
		if (op == OP_SWITCH && length > 3 && !m->ids[m->words[block->last + 1]].narrow)
			return false;
		for (uint32_t i = 0; i < successor_count(m, block); i++)
			if (!is_label(m, successor(m, block, i)))
				return false;
		if (block->merge == 0)
			continue;
		uint32_t named = has_merge(m, block, OP_LOOP_MERGE) ? 2 : 1;
		for (uint32_t i = 1; i <= named; i++) {
			if (!is_label(m, m->words[block->merge + i]))
				return false;
			m->ids[m->words[block->merge + i]].exit = true;
		}
	}
	return true;
}

/* False: the module is not understood, or there is no memory. */
static bool read_module(module *m, const stilb_gpu_program_desc *desc)
{
	if (m->count < SPIRV_HEADER || m->words[0] != SPIRV_MAGIC || m->words[3] > SPIRV_MOST_IDS)
		return false;
	m->bound = m->words[3];
	m->ids = calloc(m->bound + 1u, sizeof *m->ids);
	bool in_block = false, entry = false;
	for (uint32_t at = SPIRV_HEADER; m->ids && at < m->count; at += length_at(m, at)) {
		uint32_t length = length_at(m, at);
		if (length == 0 || length > m->count - at)
			return false;
		if (op_at(m, at) == OP_FUNCTION && m->body == 0)
			m->body = at;
		if (m->body > 0 ? !read_instruction(m, at, &in_block, &entry) : !read_declaration(m, at, desc))
			return false;
	}
	return m->ids && m->body > 0 && !in_block && labels_exist(m);
}

typedef struct order_step {
	module_block *block;
	uint32_t next; /* successor that is looked at next */
} order_step;

/* The blocks that a path leads to from a function's first one, behind those of the functions before. */
static void order_from(module *m, module_block *entry, order_step *stack)
{
	uint32_t depth = 0, first = m->order_count;
	entry->live = true; /* seen, for as long as the order is made */
	stack[depth++] = (order_step){entry, 0};
	while (depth > 0) {
		order_step *top = &stack[depth - 1];
		uint32_t next = successor(m, top->block, top->next++);
		module_block *to = next > 0 ? block_of(m, next) : NULL;
		if (to && !to->live) {
			to->live = true;
			stack[depth++] = (order_step){to, 0};
		} else if (!to) {
			m->order[m->order_count++] = top->block;
			depth--;
		}
	}
	for (uint32_t a = first, b = m->order_count; a + 1 < b; a++, b--) {
		module_block *swap = m->order[a];
		m->order[a] = m->order[b - 1];
		m->order[b - 1] = swap;
	}
}

static bool order_blocks(module *m)
{
	order_step *stack = malloc((m->block_count + 1u) * sizeof *stack);
	m->order = malloc((m->block_count + 1u) * sizeof(module_block *));
	if (stack && m->order)
		for (uint32_t b = 0; b < m->block_count; b++)
			if (m->blocks[b].entry)
				order_from(m, &m->blocks[b], stack);
	free(stack);
	for (uint32_t i = 0; m->order && i < m->order_count; i++)
		m->order[i]->rank = i + 1;
	return stack && m->order;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static void write_words(module *m, const uint32_t *words, uint32_t count)
{
	memcpy(m->out + m->out_count, words, count * sizeof *words);
	m->out_count += count;
}

static void write_pair(module *m, uint32_t op, uint32_t operand)
{
	write_words(m, (uint32_t[2]){2u << 16 | op, operand}, 2);
}

/* A phi of what still comes. A loop whose continue target is a stub gets its own value back from there. */
static void write_phi(module *m, const module_block *block, uint32_t at)
{
	uint32_t start = m->out_count;
	write_words(m, &m->words[at], 3);
	for (uint32_t i = 3; i + 1 < length_at(m, at); i += 2) {
		const module_block *from = block_of(m, m->words[at + i + 1]);
		if (from && from->live && leads_to(m, from, block->label))
			write_words(m, &m->words[at + i], 2);
	}
	if (has_merge(m, block, OP_LOOP_MERGE)) {
		const module_block *back = block_of(m, m->words[block->merge + 2]);
		if (back->stub == BLOCK_STUB_CONTINUE)
			write_words(m, (uint32_t[2]){m->words[at + 2], back->label}, 2);
	}
	m->out[start] = (m->out_count - start) << 16 | OP_PHI;
}

static void write_block(module *m, const module_block *block)
{
	if (!block->live && block->stub != BLOCK_STUB_NONE) {
		write_pair(m, OP_LABEL, block->label);
		if (block->stub == BLOCK_STUB_CONTINUE)
			write_pair(m, OP_BRANCH, block->loop);
		else
			write_words(m, (uint32_t[1]){1u << 16 | OP_UNREACHABLE}, 1);
	}
	if (!block->live)
		return;
	for (uint32_t at = block->first; at < block->last; at += length_at(m, at))
		if (op_at(m, at) == OP_PHI)
			write_phi(m, block, at);
		else if (at != block->merge || !is_dissolved(m, block))
			write_words(m, &m->words[at], length_at(m, at));
	if (block->taken == 0)
		write_words(m, &m->words[block->last], length_at(m, block->last));
	else if (op_at(m, block->last) == OP_SWITCH)
		write_words(m, (uint32_t[3]){3u << 16 | OP_SWITCH, m->words[block->last + 1], block->taken}, 3);
	else
		write_pair(m, OP_BRANCH, block->taken);
}

/* Notes which ids are defined in what is written, and which only in what is not. */
static void mark_ids(module *m)
{
	for (uint32_t b = 0; b < m->block_count; b++) {
		const module_block *block = &m->blocks[b];
		for (uint32_t at = block->first; at < block->end; at += length_at(m, at)) {
			uint32_t place = result_place(op_at(m, at));
			if (place > 0 && (block->live || (at == block->first && block->stub != BLOCK_STUB_NONE)))
				m->ids[m->words[at + place]].stays = true;
			else if (place > 0)
				m->ids[m->words[at + place]].goes = true;
		}
	}
}

/* Whether an instruction before the functions names or decorates what is gone. */
static bool is_about_gone(const module *m, uint32_t at)
{
	uint32_t op = op_at(m, at);
	if (op != OP_NAME && op != OP_DECORATE && op != OP_DECORATE_ID && op != OP_DECORATE_STRING)
		return false;
	uint32_t id = length_at(m, at) > 1 ? m->words[at + 1] : m->bound;
	return id < m->bound && m->ids[id].goes && !m->ids[id].stays;
}

static void write_module(module *m)
{
	mark_ids(m);
	write_words(m, m->words, SPIRV_HEADER);
	for (uint32_t at = SPIRV_HEADER; at < m->body; at += length_at(m, at))
		if (!is_about_gone(m, at))
			write_words(m, &m->words[at], length_at(m, at));
	uint32_t b = 0;
	for (uint32_t at = m->body; at < m->count;) {
		if (b < m->block_count && m->blocks[b].first == at) {
			write_block(m, &m->blocks[b]);
			at = m->blocks[b++].end;
		} else {
			write_words(m, &m->words[at], length_at(m, at));
			at += length_at(m, at);
		}
	}
}

/* Finds what is reached, until no round finds less and the structure holds. */
static bool solve(module *m)
{
	if (!nest(m))
		return false;
	for (uint32_t live = m->order_count + 1;;) {
		uint32_t now = propagate(m);
		bool fewer = now < live;
		live = now;
		if (fewer)
			continue;
		if (structure_holds(m))
			return now < m->order_count && add_stubs(m);
		for (uint32_t i = 0; i < m->bound; i++)
			m->ids[i].known &= m->ids[i].fixed;
		for (uint32_t i = 0; i < m->order_count; i++)
			m->order[i]->live = true;
		live = m->order_count + 1;
	}
}

uint32_t *gpu_specialize(const uint32_t *words, size_t count, const stilb_gpu_program_desc *desc, size_t *out_count)
{
	assert(words && desc && out_count);
	module m = {.words = words, .count = (uint32_t)count};
	if (count <= UINT32_MAX / 2 && read_module(&m, desc) && order_blocks(&m) && solve(&m)) {
		/* A stub has at most four words, and a phi, which has three at least, may get two more. */
		m.out = malloc((2 * count + (size_t)4 * m.block_count) * sizeof *m.out);
		if (m.out)
			write_module(&m);
	}
	*out_count = m.out_count;
	free(m.ids);
	free(m.blocks);
	free(m.order);
	return m.out;
}
