#include "track_writer.hpp"

#include <string>

#include "buffered_file.hpp"
#include "spool_reader.hpp"
#include "trajectory_rows.hpp"

namespace kinetrace::recording {

Status write_tracks(const Workspace& workspace, RunCounts& counts) {
  SpoolFile<PoseRecord> poses(workspace.poses(), workspace.slice(0));
  if (Status opened = poses.open(); !opened) {
    return opened;
  }
  BufferedWriter out;
  std::uint32_t track_id = kBackgroundTrack;
  for (; const PoseRecord* pose = poses.peek(); poses.advance()) {
    if (pose->track_id == kBackgroundTrack) {
      continue;
    }
    if (pose->track_id != track_id) {
      track_id = pose->track_id;
      if (Status closed = out.close(); !closed) {
        return closed;
      }
      const std::string name = std::to_string(track_id) + ".tum";
      Result<BufferedWriter> next =
          BufferedWriter::create(workspace.config.directory / "tracks" / name, workspace.slice(1));
      if (!next) {
        return Unexpected(next.error());
      }
      out = std::move(*next);
      ++counts.tracks;
    }
    write_tum_row(pose->timestamp_ns, pose->T_world_body, out);
  }
  const Status closed = out.close();
  return poses.status() ? closed : poses.status();
}

}  // namespace kinetrace::recording
