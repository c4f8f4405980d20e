// The hot part of bundle adjustment: eight points at a time, one per vector lane.
//
// Notation: p = T_cam_anchor * X; D = d residual / d p; w = weights (measurement and robust loss); M = D^T w D;
// G = M R, so that the point's Hessian is R^T G, its coupling to the camera W = [ [p]x G ; G ], and the camera's own
// block [ [p]x M [p]x^T, [p]x M ; M [p]x^T, M ] (rotation first).
#include "bundle_kernel.hpp"

namespace kinetrace::refinement::KINETRACE_KERNEL_ISA {
namespace {

#define KINETRACE_INLINE [[gnu::always_inline]] inline

using Double8 __attribute__((vector_size(64))) = double;
using Int8 = decltype(Float8{} < Float8{});

constexpr int kMaxFrames = 32;
// A point's depth may be almost unobserved: pivots of its Hessian stay above this fraction of the diagonal, the
// resolution of single precision.
constexpr float kMinRelativePivot = 1e-6F;
constexpr float kMinPivot = 1e-30F;
constexpr float kMaxStepOverDepth = 0.5F;

KINETRACE_INLINE Float8 splat(float value) {
  return value - Float8{};
}
KINETRACE_INLINE Float8 maximum(Float8 a, Float8 b) {
  return a > b ? a : b;
}
KINETRACE_INLINE Float8 minimum(Float8 a, Float8 b) {
  return a < b ? a : b;
}
KINETRACE_INLINE Float8 square_root(Float8 a) {
  Float8 root;
  for (int lane = 0; lane < kLanes; ++lane) {
    root[lane] = __builtin_sqrtf(a[lane]);
  }
  return root;
}
/// Natural logarithm of a >= 1 to single precision: exponent, and the series of atanh for the mantissa in [0.71, 1.41].
KINETRACE_INLINE Float8 logarithm(Float8 a) {
  constexpr int kMantissaBits = 23;
  constexpr int kRootHalfBits = 0x3f3504f3;  // sqrt(1/2): the mantissa begins there, not at 1.
  const Int8 bits = reinterpret_cast<Int8>(a) - kRootHalfBits;
  const Int8 exponent = bits >> kMantissaBits;
  const Float8 mantissa = reinterpret_cast<Float8>(reinterpret_cast<Int8>(a) - (exponent << kMantissaBits));
  const Float8 t = (mantissa - 1.F) / (mantissa + 1.F);
  const Float8 t2 = t * t;
  const Float8 series = 2.F + t2 * (2.F / 3.F + t2 * (2.F / 5.F + t2 * (2.F / 7.F)));
  return 0.69314718F * __builtin_convertvector(exponent, Float8) + t * series;
}
KINETRACE_INLINE double sum_lanes(Double8 a) {
  return ((a[0] + a[1]) + (a[2] + a[3])) + ((a[4] + a[5]) + (a[6] + a[7]));
}

struct Vector3 {
  Float8 x, y, z;
};

KINETRACE_INLINE Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
KINETRACE_INLINE Vector3 transform(const KernelPose& pose, const PointLanes& point) {
  const float* r = pose.rotation;
  return {r[0] * point.x + r[1] * point.y + r[2] * point.z + pose.translation[0],
          r[3] * point.x + r[4] * point.y + r[5] * point.z + pose.translation[1],
          r[6] * point.x + r[7] * point.y + r[8] * point.z + pose.translation[2]};
}

/// One frame's observations of eight points, linearised. Unused members cost nothing once inlined.
struct Observation {
  Vector3 p;         ///< Camera frame.
  Int8 in_front;     ///< Lanes observed and in front of the camera.
  Float8 loss;       ///< Robust loss.
  Vector3 gradient;  ///< D^T w residual.
  Float8 mxx, mxz, myy, myz, mzz;
};

struct Lens {
  ReprojectionModel<Float8> model;
  Float8 min_depth_m, robust_scale, behind_loss;
};

KINETRACE_INLINE Lens lens_of(const KernelProblem& problem) {
  return {{splat(problem.model.fx), splat(problem.model.fy), splat(problem.model.cx), splat(problem.model.cy),
           splat(problem.model.bf)},
          splat(problem.min_depth_m),
          splat(problem.robust_scale),
          splat(problem.behind_loss)};
}

KINETRACE_INLINE Observation look(const Lens& lens, const KernelPose& pose, const PointLanes& point,
                                  const ObservationLanes& seen) {
  Observation s;
  s.p = transform(pose, point);
  const Float8 zero{};
  const Int8 is_seen = seen.left_weight > zero;
  const Int8 is_ahead = s.p.z > lens.min_depth_m;
  s.in_front = is_seen & is_ahead;
  const Float8 z = is_ahead ? s.p.z : lens.min_depth_m;
  const StereoReprojection<Float8> r =
      stereo_reprojection(lens.model, s.p.x, s.p.y, z, seen.u_left_px, seen.v_px, seen.u_right_px);

  const Float8 squared = seen.left_weight * (r.residual[0] * r.residual[0] + r.residual[1] * r.residual[1]) +
                         seen.right_weight * r.residual[2] * r.residual[2];
  const Float8 spread = 1.F + squared / lens.robust_scale;
  const Float8 robust_weight = 1.F / spread;
  s.loss = is_seen ? (is_ahead ? lens.robust_scale * logarithm(spread) : lens.behind_loss) : zero;

  const Float8 left = s.in_front ? seen.left_weight * robust_weight : zero;
  const Float8 right = s.in_front ? seen.right_weight * robust_weight : zero;
  const Float8 left_r0 = left * r.residual[0];
  const Float8 left_r1 = left * r.residual[1];
  const Float8 right_r2 = right * r.residual[2];
  s.gradient = {r.du_dx * (left_r0 + right_r2), r.dv_dy * left_r1,
                r.du_left_dz * left_r0 + r.dv_dz * left_r1 + r.du_right_dz * right_r2};
  const Float8 left_dz = left * r.du_left_dz;
  const Float8 right_dz = right * r.du_right_dz;
  s.mxx = (left + right) * r.du_dx * r.du_dx;
  s.mxz = r.du_dx * (left_dz + right_dz);
  s.myy = left * r.dv_dy * r.dv_dy;
  s.myz = left * r.dv_dy * r.dv_dz;
  s.mzz = left_dz * r.du_left_dz + left * r.dv_dz * r.dv_dz + right_dz * r.du_right_dz;
  return s;
}

/// G = M R by columns: column c is M times column c of the rotation.
KINETRACE_INLINE Vector3 coupling_column(const Observation& s, const float* rotation, int c) {
  const float rx = rotation[c];
  const float ry = rotation[3 + c];
  const float rz = rotation[6 + c];
  return {s.mxx * rx + s.mxz * rz, s.myy * ry + s.myz * rz, s.mxz * rx + s.myz * ry + s.mzz * rz};
}
KINETRACE_INLINE Float8 rotate_back(const float* rotation, int c, const Vector3& v) {
  return rotation[c] * v.x + rotation[3 + c] * v.y + rotation[6 + c] * v.z;
}

struct PointHessian {
  Float8 h[6] = {};  ///< Lower triangle, row by row.
  Float8 gradient[3] = {};
};

KINETRACE_INLINE void add_to_point(const Observation& s, const float* rotation, const Vector3 coupling[3],
                                   PointHessian& point) {
  int k = 0;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c <= r; ++c) {
      point.h[k++] += rotate_back(rotation, r, coupling[c]);
    }
    point.gradient[r] += rotate_back(rotation, r, s.gradient);
  }
}

KINETRACE_INLINE void add_to_frame(const Observation& s, FrameSums& frame) {
  const Vector3& p = s.p;
  const Float8 n[3][3] = {{p.y * s.mxz, p.y * s.myz - p.z * s.myy, p.y * s.mzz - p.z * s.myz},
                          {p.z * s.mxx - p.x * s.mxz, -p.x * s.myz, p.z * s.mxz - p.x * s.mzz},
                          {-p.y * s.mxx, p.x * s.myy, p.x * s.myz - p.y * s.mxz}};  // [p]x M
  Float8* h = frame.hessian;
  h[0] += p.y * n[0][2] - p.z * n[0][1];
  h[1] += p.y * n[1][2] - p.z * n[1][1];
  h[2] += p.z * n[1][0] - p.x * n[1][2];
  h[3] += p.y * n[2][2] - p.z * n[2][1];
  h[4] += p.z * n[2][0] - p.x * n[2][2];
  h[5] += p.x * n[2][1] - p.y * n[2][0];
  for (int r = 0; r < 3; ++r) {
    h[6 + r] += n[r][0];
    h[10 + r] += n[r][1];
    h[15 + r] += n[r][2];
  }
  h[9] += s.mxx;
  h[14] += s.myy;
  h[18] += s.mxz;
  h[19] += s.myz;
  h[20] += s.mzz;
  const Vector3 torque = cross(p, s.gradient);
  Float8* g = frame.reduced_gradient;
  g[0] += torque.x;
  g[1] += torque.y;
  g[2] += torque.z;
  g[3] += s.gradient.x;
  g[4] += s.gradient.y;
  g[5] += s.gradient.z;
}

KINETRACE_INLINE Float8 clamped_root(Float8 pivot, Float8 diagonal) {
  return square_root(maximum(pivot, kMinRelativePivot * diagonal + kMinPivot));
}

/// L^-1 with L L^T = the point's Hessian, its diagonal raised by the fraction `damping`.
KINETRACE_INLINE void invert(const PointHessian& point, float damping, PointFactor& factor) {
  const Float8* h = point.h;
  const float raise = 1.F + damping;
  const Float8 l00 = clamped_root(raise * h[0], h[0]);
  const Float8 i00 = 1.F / l00;
  const Float8 l10 = h[1] * i00;
  const Float8 l20 = h[3] * i00;
  const Float8 i11 = 1.F / clamped_root(raise * h[2] - l10 * l10, h[2]);
  const Float8 l21 = (h[4] - l20 * l10) * i11;
  const Float8 i22 = 1.F / clamped_root(raise * h[5] - l20 * l20 - l21 * l21, h[5]);
  const Float8 i10 = -l10 * i00 * i11;
  Float8* inverse = factor.inverse_cholesky;
  inverse[0] = i00;
  inverse[1] = i10;
  inverse[2] = i11;
  inverse[3] = -(l20 * i00 + l21 * i10) * i22;
  inverse[4] = -l21 * i11 * i22;
  inverse[5] = i22;
  for (int r = 0; r < 3; ++r) {
    factor.gradient[r] = point.gradient[r];
  }
}

/// A 6 x 3 matrix per lane: the coupling W of a frame and eight points, later U = W L^-T.
struct Coupling {
  Float8 row[6][3];
};

/// The free frames of one group with their couplings.
struct GroupCouplings {
  int count = 0;
  int place[kMaxFrames];  ///< In the camera system, ascending.
  Coupling coupling[kMaxFrames];
};

KINETRACE_INLINE void store_coupling(const Observation& s, const Vector3 coupling[3], Coupling& w) {
  for (int c = 0; c < 3; ++c) {
    const Vector3 torque = cross(s.p, coupling[c]);
    w.row[0][c] = torque.x;
    w.row[1][c] = torque.y;
    w.row[2][c] = torque.z;
    w.row[3][c] = coupling[c].x;
    w.row[4][c] = coupling[c].y;
    w.row[5][c] = coupling[c].z;
  }
}

/// W becomes U = W L^-T; subtracts U y, with y = L^-1 gradient, from the frame's gradient.
KINETRACE_INLINE void reduce(const PointFactor& factor, const Float8 y[3], Coupling& w, FrameSums& frame) {
  const Float8* inverse = factor.inverse_cholesky;
  for (int r = 0; r < 6; ++r) {
    Float8* row = w.row[r];
    row[2] = row[0] * inverse[3] + row[1] * inverse[4] + row[2] * inverse[5];
    row[1] = row[0] * inverse[1] + row[1] * inverse[2];
    row[0] = row[0] * inverse[0];
    frame.reduced_gradient[r] -= row[0] * y[0] + row[1] * y[1] + row[2] * y[2];
  }
}

/// Adds U_i U_j^T to a block. Three rows at a time keep U_i in registers and load U_j half as often.
KINETRACE_INLINE void add_block(const Coupling& a, const Coupling& b, BlockSums& block) {
  constexpr int kRows = 3;
  for (int r = 0; r < 6; r += kRows) {
    for (int c = 0; c < 6; ++c) {
      for (int k = r; k < r + kRows; ++k) {
        block.entry[6 * k + c] += a.row[k][0] * b.row[c][0] + a.row[k][1] * b.row[c][1] + a.row[k][2] * b.row[c][2];
      }
    }
  }
}

Double8 eliminate_group(const KernelProblem& problem, const Lens& lens, const PointGroup& group,
                        const PointLanes& points, float damping, PointFactor& factor, FrameSums* frames,
                        BlockSums* blocks) {
  GroupCouplings couplings;
  PointHessian hessian;
  Float8 loss{};
  const ObservationLanes* seen = problem.observations + group.first_observation;
  for (std::uint32_t rest = group.frames; rest != 0; rest &= rest - 1, ++seen) {
    const int frame = __builtin_ctz(rest);
    const KernelPose& pose = problem.poses[frame];
    const Observation s = look(lens, pose, points, *seen);
    loss += s.loss;
    const Vector3 coupling[3] = {coupling_column(s, pose.rotation, 0), coupling_column(s, pose.rotation, 1),
                                 coupling_column(s, pose.rotation, 2)};
    add_to_point(s, pose.rotation, coupling, hessian);
    const int place = problem.free_index[frame];
    if (place >= 0) {
      add_to_frame(s, frames[place]);
      couplings.place[couplings.count] = place;
      store_coupling(s, coupling, couplings.coupling[couplings.count]);
      ++couplings.count;
    }
  }
  invert(hessian, damping, factor);
  const Float8* inverse = factor.inverse_cholesky;
  const Float8* g = factor.gradient;
  const Float8 y[3] = {inverse[0] * g[0], inverse[1] * g[0] + inverse[2] * g[1],
                       inverse[3] * g[0] + inverse[4] * g[1] + inverse[5] * g[2]};
  for (int i = 0; i < couplings.count; ++i) {
    reduce(factor, y, couplings.coupling[i], frames[couplings.place[i]]);
    for (int j = 0; j <= i; ++j) {
      add_block(couplings.coupling[i], couplings.coupling[j],
                blocks[block_index(couplings.place[i], couplings.place[j])]);
    }
  }
  return __builtin_convertvector(loss, Double8);
}

double eliminate_points(const KernelProblem& problem, float damping, PointFactor* factors, FrameSums* frames,
                        BlockSums* blocks) {
  for (int i = 0; i < problem.free_frames; ++i) {
    frames[i] = FrameSums{};
  }
  for (int i = 0; i < block_index(problem.free_frames, 0); ++i) {
    blocks[i] = BlockSums{};
  }
  const Lens lens = lens_of(problem);
  Double8 loss{};
  for (int g = 0; g < problem.group_count; ++g) {
    loss += eliminate_group(problem, lens, problem.groups[g], problem.points[g], damping, factors[g], frames, blocks);
  }
  return 0.5 * sum_lanes(loss);
}

/// -H^-1 (gradient + sum W^T camera_step), at most half the smallest depth at which the point is seen.
KINETRACE_INLINE PointLanes point_step(const KernelProblem& problem, const Lens& lens, const PointGroup& group,
                                       const PointLanes& points, const PointFactor& factor, const float* camera_step) {
  Float8 g[3] = {factor.gradient[0], factor.gradient[1], factor.gradient[2]};
  Float8 depth_m = splat(__FLT_MAX__);
  const ObservationLanes* seen = problem.observations + group.first_observation;
  for (std::uint32_t rest = group.frames; rest != 0; rest &= rest - 1, ++seen) {
    const int frame = __builtin_ctz(rest);
    const KernelPose& pose = problem.poses[frame];
    const Observation s = look(lens, pose, points, *seen);
    depth_m = s.in_front ? minimum(depth_m, s.p.z) : depth_m;
    const int place = problem.free_index[frame];
    if (place < 0) {
      continue;
    }
    const float* step = camera_step + std::ptrdiff_t{6} * place;
    const Vector3 turn = cross({splat(step[0]), splat(step[1]), splat(step[2])}, s.p);
    const Vector3 moved{turn.x + step[3], turn.y + step[4], turn.z + step[5]};
    for (int c = 0; c < 3; ++c) {
      const Vector3 column = coupling_column(s, pose.rotation, c);
      g[c] += column.x * moved.x + column.y * moved.y + column.z * moved.z;
    }
  }
  const Float8* inverse = factor.inverse_cholesky;
  const Float8 y[3] = {inverse[0] * g[0], inverse[1] * g[0] + inverse[2] * g[1],
                       inverse[3] * g[0] + inverse[4] * g[1] + inverse[5] * g[2]};
  const Vector3 step{inverse[0] * y[0] + inverse[1] * y[1] + inverse[3] * y[2], inverse[2] * y[1] + inverse[4] * y[2],
                     inverse[5] * y[2]};
  const Float8 length = square_root(step.x * step.x + step.y * step.y + step.z * step.z);
  const Float8 limit = kMaxStepOverDepth * depth_m;
  const Float8 scale = length > limit ? -limit / length : splat(-1.F);
  return {scale * step.x, scale * step.y, scale * step.z};
}

Double8 loss_at(const KernelProblem& problem, const Lens& lens, const PointGroup& group, const PointLanes& points,
                const KernelPose* poses) {
  Float8 loss{};
  const ObservationLanes* seen = problem.observations + group.first_observation;
  for (std::uint32_t rest = group.frames; rest != 0; rest &= rest - 1, ++seen) {
    loss += look(lens, poses[__builtin_ctz(rest)], points, *seen).loss;
  }
  return __builtin_convertvector(loss, Double8);
}

double move_points(const KernelProblem& problem, const PointFactor* factors, const float* camera_step,
                   const KernelPose* moved_poses, PointLanes* moved) {
  const Lens lens = lens_of(problem);
  Double8 loss{};
  for (int g = 0; g < problem.group_count; ++g) {
    const PointGroup& group = problem.groups[g];
    const PointLanes& points = problem.points[g];
    const PointLanes step = point_step(problem, lens, group, points, factors[g], camera_step);
    moved[g] = {points.x + step.x, points.y + step.y, points.z + step.z};
    loss += loss_at(problem, lens, group, moved[g], moved_poses);
  }
  return 0.5 * sum_lanes(loss);
}

}  // namespace

const BundleKernel bundle_kernel{eliminate_points, move_points};

}  // namespace kinetrace::refinement::KINETRACE_KERNEL_ISA
