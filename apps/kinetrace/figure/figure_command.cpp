#include <cstdio>
#include <memory>
#include <utility>

#include <CLI/CLI.hpp>

#include "cli/commands.hpp"
#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "cli/option_checks.hpp"
#include "cli/progress.hpp"
#include "figure/figure_film.hpp"
#include "figure/figure_overlay.hpp"
#include "figure/figure_page.hpp"
#include "figure/figure_scene.hpp"
#include "figure/picture_place.hpp"
#include "kinetrace/core/files.hpp"

namespace kinetrace::app {
namespace {

struct FigureOptions {
  std::filesystem::path run;
  std::optional<std::int64_t> frame;    ///< None: the frame that shows most.
  std::optional<std::uint32_t> object;  ///< None: see figure_choice.hpp.
  std::filesystem::path out;            ///< PNG file; empty: figure.png in the run folder.
  std::filesystem::path overlay;        ///< Folder for a picture of each frame; empty: none.
  std::filesystem::path film;           ///< The same, above the trajectories so far; empty: none.
  std::string dataset;                  ///< "LAYOUT:PATH" of a moved recording; empty: as in run.json.
  bool quiet = false;
};

/// A run folder, opened for drawing.
struct Source {
  figure::FigureRun run;
  recording::MaskFrames masks;
  std::unique_ptr<figure::RecordedImages> images;  ///< Null if the recording is not at the path in run.json.
  std::string image_problem;
};

Outcome<Source> open_source(const FigureOptions& options) {
  Result<figure::FigureRun> run = figure::FigureRun::open(options.run);
  if (!run) {
    return failure(run.error());
  }
  Result<recording::MaskFrames> masks = recording::MaskFrames::open(run->run());
  if (!masks) {
    return failure(masks.error());
  }
  for (const std::string& note : run->run().notes) {
    print_warning(note);
  }
  Source source{std::move(*run), std::move(*masks), nullptr, ""};
  Result<figure::RecordedImages> images = figure::RecordedImages::open(source.run.run(), options.dataset);
  if (images) {
    source.images = std::make_unique<figure::RecordedImages>(std::move(*images));
    return source;
  }
  // A missing recording is an error only if the user named it or asked for pictures of its frames; a figure is useful
  // without images.
  if (!options.dataset.empty() || !options.overlay.empty() || !options.film.empty()) {
    return failure(images.error());
  }
  source.image_problem = images.error().message;
  return source;
}

Outcome<figure::Scene> draw_figure(const FigureOptions& options, Source& source, const std::filesystem::path& file) {
  if (const Status free = figure::check_replaceable(file); !free) {
    return failure(free.error());
  }
  Result<figure::Scene> scene = figure::make_scene(source.run, {options.frame, options.object}, source.images.get(),
                                                   source.image_problem, source.masks);
  if (!scene) {
    return failure(scene.error());
  }
  if (scene->image.empty()) {
    print_warning("the figure has no images: " + scene->image_problem + "; --dataset LAYOUT:PATH says where they are");
  }
  if (const Status written = figure::draw_page(*scene).write_png(file); !written) {
    return failure(written.error());
  }
  return std::move(*scene);
}

using FrameWriter = decltype(&figure::write_overlay);

/// A picture of each frame into the folder. Returns an exit code.
int write_frames(FrameWriter write, const FigureOptions& options, Source& source,
                 const std::filesystem::path& directory) {
  Progress progress(!options.quiet, static_cast<std::int64_t>(source.run.run().camera.size()));
  catch_interrupts();
  const Result<std::int64_t> written =
      write(source.run, *source.images, source.masks, directory, [&](std::int64_t frames, int objects) {
        progress.show(frames, objects);
        return interrupted_by() == 0;
      });
  progress.clear();
  if (!written) {
    return report(to_failure(written.error()));
  }
  if (!options.quiet) {
    std::printf("%lld pictures in %s\n", static_cast<long long>(*written), directory.c_str());
  }
  return interrupted_by() == 0 ? 0 : kSignalBase + interrupted_by();
}

int figure_command(const FigureOptions& options) {
  const bool writes_both = !options.overlay.empty() && !options.film.empty();
  if (writes_both && is_inside(options.overlay, options.film) && is_inside(options.film, options.overlay)) {
    return report({ExitCode::kUsage, "--overlay and --film: " + options.film.string() +
                                         " cannot hold both, their pictures have the same names; name two folders"});
  }
  Outcome<Source> source = open_source(options);
  if (!source) {
    return report(source.error());
  }
  const std::filesystem::path file = options.out.empty() ? options.run / "figure.png" : options.out;
  const Outcome<figure::Scene> scene = draw_figure(options, *source, file);
  if (!scene) {
    return report(scene.error());
  }
  if (!options.quiet) {
    std::printf("Figure of frame %lld in %s\n", static_cast<long long>(scene->frame), file.c_str());
  }
  int exit_code = 0;
  if (!options.overlay.empty()) {
    exit_code = write_frames(&figure::write_overlay, options, *source, options.overlay);
  }
  if (exit_code == 0 && !options.film.empty()) {
    exit_code = write_frames(&figure::write_film, options, *source, options.film);
  }
  return exit_code;
}

void add_options(CLI::App& figure, FigureOptions& options) {
  figure.add_option("RUN", options.run, "Run folder")->required();
  figure
      .add_option("--frame", options.frame, "Frame to draw; without it, the one that shows most of the moving objects")
      ->type_name("N");
  figure.add_option("--object", options.object, "Object to draw in 3-D; without it, the most visible one in the frame")
      ->type_name("ID");
  figure.add_option("--out", options.out, "PNG file; without it, figure.png in the run folder")
      ->type_name("FILE")
      ->check(named_as(".png"));
  figure
      .add_option("--overlay", options.overlay,
                  "Also writes every frame into this folder, with masks, boxes, speeds and trails drawn in")
      ->type_name("DIR");
  figure
      .add_option("--film", options.film,
                  "Also writes these frames into this folder, above the trajectories so far, 720 pixels wide: pictures "
                  "of a film")
      ->type_name("DIR");
  figure.add_option("--dataset", options.dataset, "Present location of the recording, if it has moved since the run")
      ->type_name("LAYOUT:PATH");
  figure.add_flag("--quiet", options.quiet, "Prints nothing but warnings and errors");
}

}  // namespace

Action add_figure(CLI::App& command) {
  return bind_options(command, add_options, figure_command);
}

}  // namespace kinetrace::app
