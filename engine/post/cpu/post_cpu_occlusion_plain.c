/* Rows of occlusion in the architecture's least instruction set. */
#include "post/cpu/post_cpu_occlusion_rows.h"

const occlusion_rows post_cpu_occlusion_plain = {rows_ask, rows_smooth, rows_share};
