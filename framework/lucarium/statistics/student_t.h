// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>

namespace lucarium {

/// P(|T| > |t|) for Student's t distribution with `dof` > 0 degrees of freedom, which need not be whole.
double student_t_tail(double t, double dof);

/// The t that |T| exceeds with probability `level` in (0, 1); 0.05 for a 95 % interval.
double student_t_quantile(double level, double dof);

/// Level of one of `tests` independent tests so that all together fail by chance with probability `level` (Šidák).
double sidak_level(double level, size_t tests);

}  // namespace lucarium
