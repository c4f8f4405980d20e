// Runs a neural network on single images, to examine a model before use.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <map>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>

#include "cli/commands.hpp"
#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "cli/printable.hpp"
#include "drawing/canvas.hpp"
#include "drawing/color.hpp"
#include "kinetrace/core/class_name.hpp"
#include "kinetrace/core/config_check.hpp"
#include "kinetrace/core/files.hpp"
#include "kinetrace/imaging/image_info.hpp"
#include "kinetrace/imaging/png_writer.hpp"
#include "segmentation/model_file.hpp"
#include "segmentation/picture_file.hpp"
#include "segmentation/picture_network.hpp"

namespace kinetrace::app {
namespace {

namespace fs = std::filesystem;
using Masks = std::span<const RunLengthMask>;

struct SegmentOptions {
  std::vector<std::filesystem::path> images;  ///< Files, or folders of files.
  std::filesystem::path right;                ///< Folder of the other camera's pictures; may be empty.
  std::filesystem::path model;                ///< YAML; empty: the bundled one.
  std::filesystem::path out;
  int threads = 1;
  bool quiet = false;
};

constexpr std::uint16_t kMotsClass = 1000;

/// Calls visit(x, y) for every pixel of a mask.
template <typename Visit>
void for_each_pixel(const RunLengthMask& mask, Visit&& visit) {
  const int width = mask.box_px.width();
  int at = 0;
  bool inside = false;
  for (const std::uint16_t run : mask.runs) {
    for (int end = at + run; at < end; ++at) {
      if (inside) {
        visit(mask.box_px.x0 + at % width, mask.box_px.y0 + at / width);
      }
    }
    inside = !inside;
  }
}

Status write_masks(const fs::path& path, Masks masks, GrayView image) {
  std::vector<std::uint16_t> pixels(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  std::uint16_t instance = 0;
  for (const RunLengthMask& mask : masks) {
    const auto value = static_cast<std::uint16_t>(
        mask.class_id == kIgnoreClass ? kIgnoreClass * kMotsClass : mask.class_id * kMotsClass + ++instance);
    for_each_pixel(mask, [&](int x, int y) {
      std::uint16_t& pixel =
          pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x)];
      pixel = pixel == 0 ? value : pixel;  // Earlier masks lie over later ones.
    });
  }
  return imaging::write_png_gray16(path.c_str(), {pixels.data(), image.width, image.height, image.width});
}

Status draw_masks(const fs::path& path, Masks masks, GrayView image) {
  drawing::Canvas canvas(image.width, image.height, drawing::kPaper);
  const drawing::Rect whole{0.0, 0.0, static_cast<double>(image.width), static_cast<double>(image.height)};
  canvas.image(image, whole);
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  const GrayView view{pixels.data(), image.width, image.height, image.width};
  std::uint32_t id = 0;
  for (const RunLengthMask& mask : masks) {
    const drawing::Color colour = drawing::track_style(++id).color;
    std::fill(pixels.begin(), pixels.end(), std::uint8_t{0});
    for_each_pixel(mask, [&](int x, int y) {
      pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x)] = 1;
    });
    canvas.mask(view, whole, colour, 0.4);
    canvas.mask_outline(view, whole, {.color = colour, .width_px = 1.5});
    std::array<char, 64> label{};
    std::snprintf(label.data(), label.size(), "%s %.2f", ClassName(mask.class_id).c_str(),
                  static_cast<double>(mask.score));
    canvas.text({static_cast<double>(mask.box_px.x0), static_cast<double>(std::max(12, mask.box_px.y0 - 4))},
                label.data(), {.size_px = 8.0, .color = colour, .bold = true, .halo_px = 2.0});
  }
  return canvas.write_png(path, imaging::PngEffort::kFast);
}

fs::path result_name(const fs::path& file) {
  return file.stem().string() + ".png";
}

struct ResultKind {
  const char* folder;
  FileKind file;
};
constexpr std::array<ResultKind, 2> kResults{
    ResultKind{"masks", {"image of masks", [](const fs::path& path) { return imaging::is_png(path.c_str(), 1, 16); }}},
    ResultKind{"overlay", {"overlay", &imaging::is_drawn_picture}}};

/// A result replaces neither its own picture nor any file but an earlier result. Errors: kInvalidArgument, kOccupied.
Status check_place(const fs::path& picture, const fs::path& out) {
  for (const ResultKind& kind : kResults) {
    const fs::path place = out / kind.folder / result_name(picture);
    std::error_code error;
    if (fs::equivalent(place, picture, error)) {
      return fail(ErrorCode::kInvalidArgument,
                  picture.string() + ": would be replaced by its own result; name another folder --out");
    }
    if (Status free = check_same_kind(place, kind.file); !free) {
      return free;
    }
  }
  return {};
}

/// Each result needs a name of its own. Errors: kInvalidArgument, and those of check_place.
Status check_places(const std::vector<fs::path>& files, const fs::path& out) {
  std::map<fs::path, const fs::path*> picture_of;
  for (const fs::path& file : files) {
    const fs::path name = result_name(file);
    if (const auto [first, is_new] = picture_of.emplace(name, &file); !is_new) {
      return fail(ErrorCode::kInvalidArgument, first->second->string() + " and " + file.string() +
                                                   ": both would become " + name.string() +
                                                   "; name a folder --out for each");
    }
    if (Status free = check_place(file, out); !free) {
      return free;
    }
  }
  return {};
}

/// Creates the folders of results. Errors: kCannotCreate.
Outcome<void> make_folders(const fs::path& out) {
  for (const ResultKind& kind : kResults) {
    std::error_code error;
    fs::create_directories(out / kind.folder, error);
    if (error) {
      return Unexpected(Failure{ExitCode::kCannotCreate, (out / kind.folder).string() + ": " + error.message()});
    }
  }
  return {};
}

Outcome<void> write_results(const SegmentOptions& options, const fs::path& file, Masks masks, GrayView image) {
  if (Outcome<void> made = make_folders(options.out); !made) {
    return made;
  }
  const fs::path name = result_name(file);
  const Status written = first_failure({write_masks(options.out / "masks" / name, masks, image),
                                        draw_masks(options.out / "overlay" / name, masks, image)});
  return written ? Outcome<void>() : failure(written.error());
}

std::string size_text(GrayView image) {
  return std::to_string(image.width) + "x" + std::to_string(image.height);
}

/// Reads a picture and, with --right, the one of the same name. Errors: those of PictureFiles::read, and kBadFormat (of
/// another size).
class PairReader {
 public:
  explicit PairReader(fs::path right) : right_(std::move(right)) {}

  struct Pair {
    PictureFiles::Loaded left;
    neural::Picture right;
  };
  Result<Pair> read(const fs::path& file) {
    const Result<PictureFiles::Loaded> left = left_files_.read(file);
    if (!left) {
      return Unexpected(left.error());
    }
    if (right_.empty()) {
      return Pair{*left, {}};
    }
    const fs::path right_file = right_ / file.filename();
    const Result<PictureFiles::Loaded> right = right_files_.read(right_file);
    if (!right) {
      return Unexpected(right.error());
    }
    const GrayView& a = left->gray;
    const GrayView& b = right->gray;
    if (a.width != b.width || a.height != b.height) {
      return fail(ErrorCode::kBadFormat, right_file.string() + ": is " + size_text(b) + " pixels, and " +
                                             file.string() + " " + size_text(a) + "; give the pictures of one pair");
    }
    return Pair{*left, right->picture};
  }

 private:
  fs::path right_;
  PictureFiles left_files_;
  PictureFiles right_files_;
};

/// Failures concern the network or the results.
Outcome<void> segment_picture(const SegmentOptions& options, const fs::path& file, const PairReader::Pair& pair,
                              PictureNetwork& network) {
  const PictureFiles::Loaded& loaded = pair.left;
  if (const Status ready = network.prepare(loaded.gray.width, loaded.gray.height); !ready) {
    return failure(ready.error());
  }
  const auto begun = std::chrono::steady_clock::now();
  const Result<Masks> masks = network.segment({loaded.picture, pair.right});
  const double took_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begun).count();
  if (!masks) {
    return failure(masks.error());
  }
  if (Outcome<void> written = write_results(options, file, *masks, loaded.gray); !written) {
    return written;
  }
  if (!options.quiet) {
    std::printf("%s: %zu instances in %.1f ms\n", printable(file.native()).c_str(), masks->size(), took_ms);
  }
  return {};
}

/// Pictures that cannot be read are reported and skipped. Returns the exit code of the first of them, or 0.
Outcome<int> segment_all(const SegmentOptions& options, const std::vector<fs::path>& files, PictureNetwork& network) {
  PairReader pictures(options.right);
  int exit_code = 0;
  catch_interrupts();
  for (auto file = files.begin(); file != files.end() && interrupted_by() == 0; ++file) {
    const Result<PairReader::Pair> pair = pictures.read(*file);
    if (!pair) {
      const int failed = report(to_failure(pair.error()));
      exit_code = exit_code == 0 ? failed : exit_code;
      continue;
    }
    if (const Outcome<void> done = segment_picture(options, *file, *pair, network); !done) {
      return Unexpected(done.error());
    }
  }
  return interrupted_by() == 0 ? exit_code : kSignalBase + interrupted_by();
}

Outcome<int> segment(const SegmentOptions& options) {
  const Result<neural::ModelConfig> model = load_model(options.model);
  if (!model) {
    return failure(model.error());
  }
  const Result<std::vector<fs::path>> files = picture_files(options.images);
  if (!files) {
    return failure(files.error());
  }
  if (const Status places = check_places(*files, options.out); !places) {
    return failure(places.error());
  }
  for (const fs::path& file : *files) {
    if (const auto caution = model_caution(*model, file)) {
      print_warning(*caution);
      break;
    }
  }
  PictureNetwork network(*model, options.threads, PictureFiles::kMaxSide_px);
  return segment_all(options, *files, network);
}

int segment_command(const SegmentOptions& options) {
  const Outcome<int> done = segment(options);
  return done ? *done : report(done.error());
}

void add_options(CLI::App& segment, SegmentOptions& options) {
  segment
      .add_option("IMAGES", options.images,
                  "PNG, JPEG or PGM files of any sizes, or folders of them; those that cannot be read are reported and "
                  "skipped")
      ->required();
  segment
      .add_option(
          "--right", options.right,
          "Folder of the right camera's pictures, rectified and named like the left ones: for networks that use "
          "disparities, as the one that comes with Kinetrace")
      ->type_name("DIR");
  segment
      .add_option("--model", options.model,
                  "YAML file that describes the network; without it, the one that comes with Kinetrace, trained on "
                  "simulated pictures only")
      ->type_name("MODEL.yaml");
  segment
      .add_option("--out", options.out, "Folder for masks/STEM.png (KITTI MOTS) and overlay/STEM.png; made if needed")
      ->type_name("DIR")
      ->required();
  segment.add_option("--threads", options.threads, "Threads that the network uses")
      ->check(CLI::Range(1, 16))
      ->capture_default_str();
  segment.add_flag("--quiet", options.quiet, "Prints nothing but warnings and errors");
}

}  // namespace

Action add_segment(CLI::App& command) {
  return bind_options(command, add_options, segment_command);
}

}  // namespace kinetrace::app
