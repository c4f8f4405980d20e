// Dense Cholesky, row by row: every inner loop runs along contiguous rows.
#include "bundle_kernel.hpp"

namespace kinetrace::refinement::KINETRACE_KERNEL_ISA {
namespace {

using Double4 __attribute__((vector_size(32), aligned(8), may_alias)) = double;
constexpr std::ptrdiff_t kWidth = 4;

double dot(const double* a, const double* b, std::ptrdiff_t size) {
  Double4 sum{};
  std::ptrdiff_t i = 0;
  for (; i + kWidth <= size; i += kWidth) {
    sum += *reinterpret_cast<const Double4*>(a + i) * *reinterpret_cast<const Double4*>(b + i);
  }
  double total = (sum[0] + sum[1]) + (sum[2] + sum[3]);
  for (; i < size; ++i) {
    total += a[i] * b[i];
  }
  return total;
}

bool factorise(double* a, std::ptrdiff_t size, std::ptrdiff_t stride) {
  for (std::ptrdiff_t i = 0; i < size; ++i) {
    double* row = a + i * stride;
    for (std::ptrdiff_t j = 0; j < i; ++j) {
      const double* other = a + j * stride;
      row[j] = (row[j] - dot(row, other, j)) / other[j];
    }
    const double pivot = row[i] - dot(row, row, i);
    if (!(pivot > 0.0)) {
      return false;
    }
    row[i] = __builtin_sqrt(pivot);
  }
  return true;
}

void solve(const double* l, std::ptrdiff_t size, std::ptrdiff_t stride, double* b) {
  for (std::ptrdiff_t i = 0; i < size; ++i) {
    const double* row = l + i * stride;
    b[i] = (b[i] - dot(row, b, i)) / row[i];
  }
  for (std::ptrdiff_t i = size - 1; i >= 0; --i) {
    const double* row = l + i * stride;
    b[i] /= row[i];
    for (std::ptrdiff_t j = 0; j < i; ++j) {
      b[j] -= b[i] * row[j];
    }
  }
}

}  // namespace

const CholeskyKernel cholesky_kernel{factorise, solve};

}  // namespace kinetrace::refinement::KINETRACE_KERNEL_ISA
