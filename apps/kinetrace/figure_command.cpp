#include <cstdio>
#include <memory>
#include <utility>

#include "commands.hpp"
#include "figure_film.hpp"
#include "figure_overlay.hpp"
#include "figure_page.hpp"
#include "figure_scene.hpp"
#include "interrupt.hpp"
#include "messages.hpp"
#include "progress.hpp"

namespace kinetrace::app {
namespace {

/// A run folder, opened for drawing.
struct Source {
  figure::FigureRun run;
  recording::MaskFrames masks;
  std::unique_ptr<figure::RecordedImages> images;  ///< None if the recording is not where run.json says.
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
  // Who names a recording, or wants pictures of it, needs it; a figure is of use without.
  if (!options.dataset.empty() || !options.overlay.empty() || !options.film.empty()) {
    return failure(images.error());
  }
  source.image_problem = images.error().message;
  return source;
}

Outcome<figure::Scene> draw_figure(const FigureOptions& options, Source& source, const std::filesystem::path& file) {
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

}  // namespace

int figure_command(const FigureOptions& options) {
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

}  // namespace kinetrace::app
