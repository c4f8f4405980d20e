// The one definition of the stereo reprojection residual, shared by every solver (METHOD: stereo refinement).
#pragma once

namespace kinetrace {

/// Rectified intrinsics in the solver's scalar. `bf` = fx * baseline (px m).
template <typename Scalar>
struct ReprojectionModel {
  Scalar fx, fy, cx, cy, bf;
};

/// Residual and derivatives of one stereo observation (u_left, v, u_right) of a point at `p` = T_cam_body * p_body.
///
/// residual = predicted - observed, order (u_left, v, u_right). `d_point` is d residual / d p_cam, row-major 3 x 3; the
/// rows have the pattern [a 0 b; 0 c d; a 0 e], which callers may exploit. With the project's left perturbation of
/// T_cam_body (see left_update), d residual / d (rotation, translation) = d_point * [ -skew(p_cam), I ]. `Scalar` may
/// be float, double or a SIMD vector of floats: only + - * / are used, so that every solver evaluates the very same
/// formula. Always inlined: kernels are compiled for several instruction sets, and the linker must not merge them.
template <typename Scalar>
struct StereoReprojection {
  Scalar residual[3];
  Scalar du_dx;        ///< fx / z: d u_left / d x and d u_right / d x.
  Scalar du_left_dz;   ///< -fx x / z^2.
  Scalar dv_dy;        ///< fy / z.
  Scalar dv_dz;        ///< -fy y / z^2.
  Scalar du_right_dz;  ///< -(fx x - bf) / z^2.
};

template <typename Scalar>
[[nodiscard, gnu::always_inline]] inline StereoReprojection<Scalar> stereo_reprojection(
    const ReprojectionModel<Scalar>& model, Scalar x, Scalar y, Scalar z, Scalar u_left, Scalar v, Scalar u_right) {
  const Scalar inv_z = 1.0F / z;
  const Scalar fx_x = model.fx * x;
  const Scalar fy_y = model.fy * y;
  StereoReprojection<Scalar> out;
  out.residual[0] = fx_x * inv_z + model.cx - u_left;
  out.residual[1] = fy_y * inv_z + model.cy - v;
  out.residual[2] = (fx_x - model.bf) * inv_z + model.cx - u_right;
  out.du_dx = model.fx * inv_z;
  out.dv_dy = model.fy * inv_z;
  out.du_left_dz = -fx_x * inv_z * inv_z;
  out.dv_dz = -fy_y * inv_z * inv_z;
  out.du_right_dz = -(fx_x - model.bf) * inv_z * inv_z;
  return out;
}

}  // namespace kinetrace
