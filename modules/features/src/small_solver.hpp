// Linear systems of a few unknowns, for kernel sources only.
#pragma once

namespace kinetrace::features::KINETRACE_KERNEL_ISA {

/// Solves the symmetric positive definite system a x = b in place by Cholesky decomposition; b becomes x.
template <int kSize>
static inline void solve(float (&a)[kSize][kSize], float (&b)[kSize]) {
  for (int i = 0; i < kSize; ++i) {
    for (int j = 0; j <= i; ++j) {
      float value = a[i][j];
      for (int k = 0; k < j; ++k) {
        value -= a[i][k] * a[j][k];
      }
      a[i][j] = i == j ? __builtin_sqrtf(value > 1e-6F ? value : 1e-6F) : value / a[j][j];
    }
  }
  for (int i = 0; i < kSize; ++i) {
    for (int k = 0; k < i; ++k) {
      b[i] -= a[i][k] * b[k];
    }
    b[i] /= a[i][i];
  }
  for (int i = kSize - 1; i >= 0; --i) {
    for (int k = i + 1; k < kSize; ++k) {
      b[i] -= a[k][i] * b[k];
    }
    b[i] /= a[i][i];
  }
}

}  // namespace kinetrace::features::KINETRACE_KERNEL_ISA
