// Instance masks of pictures by a neural network, with its pre- and post-processing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/export.hpp"
#include "kinetrace/core/instance_masks.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/neural/model.hpp"
#include "kinetrace/neural/picture.hpp"

namespace kinetrace::neural {

struct NetworkOptions {
  /// Path of the plugin that computes networks. Empty: kinetrace-opencv-dnn.so, as installed with Kinetrace or beside
  /// the program.
  std::string runtime = {};
  int threads = 1;       ///< Threads of the runtime, [1, 16].
  int max_width_px = 0;  ///< Of the pictures.
  int max_height_px = 0;
};

/// Running totals.
struct NetworkCounters {
  std::uint64_t pictures = 0;
  std::uint64_t instances = 0;
  std::uint64_t candidates_dropped = 0;  ///< Beyond kMaxCandidates; the weakest are dropped.
  std::uint64_t instances_dropped = 0;   ///< Beyond kMaxInstances or kMaxRuns.
};

/// Letterbox or stretch, network, decoding of its heads, non-maximum suppression, assembly of masks. Memory: from the
/// arena, except for the network's weights and layers, which the runtime allocates when the model is loaded and first
/// run. Not to be called concurrently.
class KINETRACE_API InstanceNetwork {
 public:
  static constexpr std::size_t kMaxCandidates = 1024;              ///< Before suppression.
  static constexpr std::size_t kMaxInstances = 128;                ///< Of one picture.
  static constexpr std::size_t kMaxRuns = std::size_t{32} << 10U;  ///< Of one picture, all masks together.

  [[nodiscard]] static std::size_t required_bytes(const ModelConfig& model, const NetworkOptions& options);
  /// Loads and checks the model, and runs it once on a grey picture, so that only its results can be wrong afterwards.
  /// Errors: kInvalidConfig (the description, sizes, or classes do not fit the model), kNotFound, kBadFormat (not a
  /// model, weights that are not finite), kUnsupported (runtime missing, operators that it lacks or computes wrongly),
  /// kCapacity (arena).
  [[nodiscard]] static Result<std::unique_ptr<InstanceNetwork>> create(const ModelConfig& model,
                                                                       const NetworkOptions& options, Arena& arena);
  InstanceNetwork(const InstanceNetwork&) = delete;
  InstanceNetwork& operator=(const InstanceNetwork&) = delete;
  ~InstanceNetwork();

  /// The instances of a picture, in descending score, masks in its pixels; they live until the next call. Errors:
  /// kInvalidArgument (picture larger than planned), kInternal (the runtime failed).
  [[nodiscard]] Result<std::span<const RunLengthMask>> segment(const Picture& picture);
  /// The same with the other camera's picture, used by networks with a channel of disparities. Errors: as above, and
  /// kInvalidArgument (pictures of different sizes).
  [[nodiscard]] Result<std::span<const RunLengthMask>> segment(const StereoPicture& pictures);
  /// Segments a part of the picture, scaled to fill the input: smaller objects are found. Objects cut by the part's
  /// border are dropped. Errors: as above, and kInvalidArgument (a part that is not in the picture).
  [[nodiscard]] Result<std::span<const RunLengthMask>> segment(const StereoPicture& pictures, const PixelBox& part_px);

  [[nodiscard]] const NetworkCounters& counters() const noexcept;

 private:
  struct State;
  explicit InstanceNetwork(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kinetrace::neural
