// Formulations of the refinement of objects, compared on one run with the truth of its rendered recording:
//
//     formulations RUN TRUTH
//
// All use the same observations, initial poses, true camera path, noise, loss and prior.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>
#include <vector>

#include <ceres/ceres.h>

#include "formulation_costs.hpp"
#include "formulation_pieces.hpp"
#include "kinetrace/evaluation/object_metrics.hpp"
#include "kinetrace/evaluation/similarity.hpp"
#include "kinetrace/evaluation/truth.hpp"

namespace kinetrace::batch {
namespace {

using refinement::PoseBlock;
using refinement::WorldPose;

// Prior, loss and tolerance of the refinement of objects.
constexpr double kAcceleration_mps2 = 3.0;
constexpr double kTurn_radps2 = 0.6;
constexpr double kRobustThreshold_sigmas = 1.0;
constexpr double kCostTolerance = 1e-5;
constexpr int kMaxIterations = 100;
constexpr double kGate_m = 3.0;  // As in `kinetrace evaluate`.

/// Sums over all pieces, and the size of the largest one.
struct Effort {
  double processor_s = 0.0;
  int iterations = 0;
  int max_states = 0;  ///< Scalars, not blocks.
  int max_residuals = 0;
};

/// Object-centric: points in the object frame, one pose a frame. Blocks are T_cam_obj, that of the first frame
/// constant.
class ObjectCentric {
 public:
  explicit ObjectCentric(const Piece& piece) : piece_(piece), blocks_(piece.T_world_obj.size()) {
    for (std::size_t k = 0; k < blocks_.size(); ++k) {
      refinement::from_pose(piece.T_world_cam[k].inverse() * piece.T_world_obj[k], block(k));
    }
  }
  virtual ~ObjectCentric() = default;

  virtual void add_observations() {
    for (const PointTrack& point : piece_.points) {
      double* position = add_point(point.position_m);
      for (const SeenPoint& seen : point.seen) {
        const auto [T_first, blocks] = chain_to(seen.frame);
        add_observation(seen, T_first, blocks, position);
      }
    }
  }
  /// Constant velocity in the object's own axes.
  virtual void add_prior() {
    const auto pose = [&](std::size_t k) { return WorldPose{piece_.T_world_cam[k]}; };
    for (std::size_t k = 2; k < blocks_.size(); ++k) {
      const auto [before_s, after_s] = intervals_s(k);
      problem_.AddResidualBlock(new refinement::SteadyCost({pose(k - 2), pose(k - 1), pose(k)}, before_s, after_s,
                                                           inverse_sigma(k).asDiagonal().toDenseMatrix()),
                                nullptr, block(k - 2), block(k - 1), block(k));
    }
  }
  /// Poses T_world_obj.
  std::vector<Se3> solve(Effort& effort) {
    for (std::size_t k = 0; k < blocks_.size(); ++k) {
      if (problem_.HasParameterBlock(block(k))) {
        problem_.SetManifold(block(k), &manifold_);
        ordering_->AddElementToGroup(block(k), 1);
      }
    }
    if (problem_.HasParameterBlock(block(0))) {
      problem_.SetParameterBlockConstant(block(0));
    }
    ceres::Solver::Options options;
    options.max_num_iterations = kMaxIterations;
    options.function_tolerance = kCostTolerance;
    options.gradient_tolerance = 0.0;
    options.parameter_tolerance = 0.0;
    options.logging_type = ceres::SILENT;
    choose_solver(options);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    effort.iterations += static_cast<int>(summary.iterations.size()) - 1;
    effort.max_states = std::max(effort.max_states, summary.num_effective_parameters_reduced);
    effort.max_residuals = std::max(effort.max_residuals, summary.num_residuals_reduced);
    return T_world_obj();
  }

 protected:
  /// Takes a point of the object into the camera of a frame: T_first, then the blocks.
  struct Chain {
    Se3 T_first;
    std::vector<double*> blocks;
  };
  [[nodiscard]] virtual Chain chain_to(std::size_t frame) { return {{}, {block(frame)}}; }
  [[nodiscard]] virtual std::vector<Se3> T_world_obj() const {
    std::vector<Se3> poses;
    for (std::size_t k = 0; k < blocks_.size(); ++k) {
      poses.push_back(piece_.T_world_cam[k] * refinement::to_pose(blocks_[k].data()));
    }
    return poses;
  }
  virtual void choose_solver(ceres::Solver::Options& options) const {
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.linear_solver_ordering = ordering_;
  }

  [[nodiscard]] double* block(std::size_t frame) { return blocks_[frame].data(); }
  [[nodiscard]] std::array<double, 2> intervals_s(std::size_t k) const {
    return {piece_.times_s[k - 1] - piece_.times_s[k - 2], piece_.times_s[k] - piece_.times_s[k - 1]};
  }
  [[nodiscard]] Vector6d inverse_sigma(std::size_t k) const {
    const double span_s = 0.5 * (piece_.times_s[k] - piece_.times_s[k - 2]);
    Vector6d sigma;
    sigma << Eigen::Vector3d::Constant(span_s * kTurn_radps2), Eigen::Vector3d::Constant(span_s * kAcceleration_mps2);
    return sigma.cwiseInverse();
  }
  double* add_point(const Eigen::Vector3d& position_m) {
    return points_m_.emplace_back(std::make_unique<Eigen::Vector3d>(position_m))->data();
  }
  void add_observation(const SeenPoint& seen, const Se3& T_first, std::vector<double*> blocks, double* point) {
    const BundleObservation observation{seen.px.x(), seen.px.y(), seen.px.z(),
                                        static_cast<float>(1.0 / piece_.sigma_px)};
    auto* cost = new refinement::ChainCost(piece_.geometry, observation, T_first, blocks.size());
    blocks.push_back(point);
    problem_.AddResidualBlock(cost, &loss_, blocks);
    ordering_->AddElementToGroup(point, 0);
  }

  static ceres::Problem::Options problem_options() {
    ceres::Problem::Options options;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
  }

  const Piece& piece_;
  std::vector<PoseBlock> blocks_;
  std::vector<std::unique_ptr<Eigen::Vector3d>> points_m_;
  ceres::CauchyLoss loss_{kRobustThreshold_sigmas};
  refinement::LeftPerturbation manifold_;
  ceres::Problem problem_{problem_options()};
  std::shared_ptr<ceres::ParameterBlockOrdering> ordering_ = std::make_shared<ceres::ParameterBlockOrdering>();
};

/// World points, a new one in each frame, linked by the object's motions (VDO-SLAM). Each motion is the difference of
/// two poses, so that the prior is the same.
class WorldCentric final : public ObjectCentric {
 public:
  WorldCentric(const Piece& piece, double sigma_m) : ObjectCentric(piece), sigma_m_(sigma_m) {}
  void add_observations() override {
    for (const PointTrack& point : piece_.points) {
      const SeenPoint* before = nullptr;
      double* point_before = nullptr;
      for (const SeenPoint& seen : point.seen) {
        const Se3& T_world_cam = piece_.T_world_cam[seen.frame];
        double* position = add_point(piece_.T_world_obj[seen.frame] * point.position_m);
        add_observation(seen, T_world_cam.inverse(), {}, position);
        if (before != nullptr) {
          // The error grows with each frame in between.
          const double sigma_m = sigma_m_ * std::sqrt(seen.frame - before->frame);
          problem_.AddResidualBlock(
              new refinement::MovedPointCost({piece_.T_world_cam[before->frame], T_world_cam}, sigma_m), &loss_,
              block(before->frame), block(seen.frame), point_before, position);
        }
        before = &seen;
        point_before = position;
      }
    }
  }

 protected:
  // Points are coupled: they cannot all be eliminated as one group.
  void choose_solver(ceres::Solver::Options& options) const override {
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  }

 private:
  double sigma_m_;
};

/// Points in the object frame of the first frame, poses as products of the motions since then. Blocks are those
/// motions, in the object frame.
class RelativeMotions final : public ObjectCentric {
 public:
  explicit RelativeMotions(const Piece& piece) : ObjectCentric(piece) {
    for (std::size_t k = 1; k < blocks_.size(); ++k) {
      refinement::from_pose(piece.T_world_obj[k - 1].inverse() * piece.T_world_obj[k], block(k));
    }
  }
  void add_prior() override {
    for (std::size_t k = 2; k < blocks_.size(); ++k) {
      problem_.AddResidualBlock(new refinement::SteadyMotionCost(intervals_s(k), inverse_sigma(k)), nullptr,
                                block(k - 1), block(k));
    }
  }

 protected:
  [[nodiscard]] Chain chain_to(std::size_t frame) override {
    Chain chain{piece_.T_world_cam[frame].inverse() * piece_.T_world_obj.front(), {}};
    for (std::size_t k = 1; k <= frame; ++k) {
      chain.blocks.push_back(block(k));
    }
    return chain;
  }
  [[nodiscard]] std::vector<Se3> T_world_obj() const override {
    std::vector<Se3> poses{piece_.T_world_obj.front()};
    for (std::size_t k = 1; k < blocks_.size(); ++k) {
      poses.push_back(poses.back() * refinement::to_pose(blocks_[k].data()));
    }
    return poses;
  }
};

using Maker = std::unique_ptr<ObjectCentric> (*)(const Piece&);

struct Method {
  const char* name;
  Maker make;
  double noise_scale = 1.0;
  bool by_frame_pairs = false;
};

std::vector<Method> methods() {
  // Matching errors persist for some frames, but the cost assumes independence: larger noise compensates.
  constexpr double kCorrelated = 4.0;
  const Maker object_centric = [](const Piece& piece) { return std::make_unique<ObjectCentric>(piece); };
  const Maker within_1_cm = [](const Piece& piece) -> std::unique_ptr<ObjectCentric> {
    return std::make_unique<WorldCentric>(piece, 0.01);
  };
  const Maker within_1_mm = [](const Piece& piece) -> std::unique_ptr<ObjectCentric> {
    return std::make_unique<WorldCentric>(piece, 0.001);
  };
  const Maker products = [](const Piece& piece) -> std::unique_ptr<ObjectCentric> {
    return std::make_unique<RelativeMotions>(piece);
  };
  return {{"object-centric", object_centric},
          {"object-centric, noise x 4", object_centric, kCorrelated},
          {"world-centric, 1 mm", within_1_mm},
          {"world-centric, 1 mm, noise x 4", within_1_mm, kCorrelated},
          {"world-centric, 10 mm", within_1_cm},
          {"products of motions", products},
          {"pairs of frames", object_centric, 1.0, true}};
}

/// Truth and pieces side by side. Each piece is a track of its own, since each has its own object frame.
std::vector<evaluation::ObjectFrame> frames_of(const recording::Run& run, const evaluation::Truth& truth,
                                               const std::vector<Piece>& pieces) {
  std::vector<evaluation::ObjectFrame> frames;
  for (std::size_t row = 0; row < run.camera.size(); ++row) {
    const recording::CameraRow& camera = run.camera[row];
    evaluation::ObjectFrame& frame = frames.emplace_back();
    frame.frame = camera.frame;
    frame.T_world_cam_true = truth.camera.at(camera.frame, camera.timestamp_ns, 0).value_or(camera.T_world_cam);
    std::vector<Eigen::Vector3d> true_centres_m;
    if (const auto objects = truth.objects.find(camera.frame); objects != truth.objects.end()) {
      for (const evaluation::LocatedObject& located : objects->second) {
        frame.truth.push_back(located.object);
        true_centres_m.push_back(located.center_m);
      }
    }
    std::vector<Eigen::Vector3d> centres_m;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      if (row >= pieces[i].first && row - pieces[i].first < pieces[i].T_world_obj.size()) {
        frame.tracks.push_back({static_cast<std::uint32_t>(i), evaluation::TrackEstimate{}});
        centres_m.push_back(pieces[i].box_centres_m[row - pieces[i].first]);
      }
    }
    evaluation::compare_centres(true_centres_m, centres_m, kGate_m, frame);
  }
  return frames;
}

/// Errors of frame-to-frame motions of moving rigid objects within 30 m, as in `kinetrace evaluate`.
struct Errors {
  std::size_t motions = 0;
  double rms_m = 0.0;
  double median_m = 0.0;
  double rms_deg = 0.0;
};

Errors motion_errors(std::vector<evaluation::ObjectFrame> frames, const std::vector<Piece>& pieces,
                     const std::vector<std::vector<Se3>>& T_world_obj) {
  for (std::size_t row = 0; row < frames.size(); ++row) {
    for (evaluation::TrackInFrame& track : frames[row].tracks) {
      track.estimate->status = BodyStatus::kTracked;
      track.estimate->T_world_obj = T_world_obj[track.track_id][row - pieces[track.track_id].first];
    }
  }
  const evaluation::ObjectMetrics metrics = evaluation::evaluate_objects(frames, {});
  std::vector<double> lengths_m;
  for (const evaluation::MotionSample& motion : metrics.motions) {
    lengths_m.push_back(motion.translation_m);
  }
  if (lengths_m.empty()) {
    return {};
  }
  std::sort(lengths_m.begin(), lengths_m.end());
  const evaluation::MotionErrors& motion = metrics.all.motion;
  return {lengths_m.size(), motion.translation_m.rmse().value_or(0.0), lengths_m[lengths_m.size() / 2],
          motion.rotation_deg.rmse().value_or(0.0)};
}

std::vector<std::vector<Se3>> solve_all(const Method& method, bool with_prior, const std::vector<Piece>& pieces,
                                        Effort& effort) {
  std::vector<std::vector<Se3>> T_world_obj;
  const std::clock_t start = std::clock();
  for (const Piece& original : pieces) {
    Piece piece = method.by_frame_pairs ? by_frame_pairs(original) : original;
    piece.sigma_px *= method.noise_scale;
    const std::unique_ptr<ObjectCentric> formulation = method.make(piece);
    formulation->add_observations();
    if (with_prior) {
      formulation->add_prior();
    }
    T_world_obj.push_back(formulation->solve(effort));
  }
  effort.processor_s = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  return T_world_obj;
}

void print(const char* name, const Errors& errors) {
  std::printf("| %s | %.2f | %.2f | %.4f |", name, 1e3 * errors.rms_m, 1e3 * errors.median_m, errors.rms_deg);
}

Status compare(const std::filesystem::path& run_folder, const std::filesystem::path& truth_folder) {
  const Result<recording::Run> run = recording::read_run(run_folder);
  if (!run) {
    return Unexpected(run.error());
  }
  evaluation::TruthSource source;
  source.path = truth_folder;
  const Result<evaluation::Truth> truth = evaluation::read_truth(source);
  if (!truth) {
    return Unexpected(truth.error());
  }
  const auto histories = object_histories(*run);
  if (!histories) {
    return Unexpected(histories.error());
  }
  std::vector<Piece> pieces;
  for (const auto& [track_id, history] : *histories) {
    cut_into_pieces(*run, truth->camera, history, pieces);
  }
  const std::vector<evaluation::ObjectFrame> frames = frames_of(*run, *truth, pieces);
  std::vector<std::vector<Se3>> T_world_obj;
  for (const Piece& piece : pieces) {
    T_world_obj.push_back(piece.T_world_obj);
  }
  const Errors before = motion_errors(frames, pieces, T_world_obj);
  std::printf(
      "%zu pieces, %zu motions; mm per frame RMS and median, deg RMS; seconds; states and residuals of the largest "
      "piece\n",
      pieces.size(), before.motions);
  print("the run", before);
  for (const bool with_prior : {true, false}) {
    std::printf("\n%s prior\n", with_prior ? "with" : "without");
    for (const Method& method : methods()) {
      Effort effort;
      print(method.name, motion_errors(frames, pieces, solve_all(method, with_prior, pieces, effort)));
      std::printf(" %.1f | %d iterations | %d | %d |\n", effort.processor_s, effort.iterations, effort.max_states,
                  effort.max_residuals);
    }
  }
  return {};
}

}  // namespace
}  // namespace kinetrace::batch

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: formulations RUN TRUTH\n", stderr);
    return 64;
  }
  if (const kinetrace::Status compared = kinetrace::batch::compare(argv[1], argv[2]); !compared) {
    std::fprintf(stderr, "%s\n", compared.error().message.c_str());
    return 1;
  }
  return 0;
}
