/* Rows of occlusion with AVX2. */
#include "post/cpu/post_cpu_occlusion.h"

#include <stddef.h>

#if defined(__AVX2__)

#include "post/cpu/post_cpu_occlusion_rows.h"

static const occlusion_rows rows = {rows_ask, rows_smooth, rows_share};
const occlusion_rows *const post_cpu_occlusion_avx2 = &rows;

#else

const occlusion_rows *const post_cpu_occlusion_avx2 = NULL;

#endif
