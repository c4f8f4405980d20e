#include "capture/v4l2/v4l2_mode.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <iterator>
#include <linux/videodev2.h>
#include <optional>
#include <utility>

#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

// The usual code of a format comes first; the last one that a device supports is used. NV12 in two planes: only the
// first plane, the luminance, has to be mapped.
constexpr std::array<std::pair<PixelFormat, __u32>, 8> kCodes{{{PixelFormat::kGrey8, V4L2_PIX_FMT_GREY},
                                                               {PixelFormat::kGrey10, V4L2_PIX_FMT_Y10},
                                                               {PixelFormat::kGrey16, V4L2_PIX_FMT_Y16},
                                                               {PixelFormat::kYuyv, V4L2_PIX_FMT_YUYV},
                                                               {PixelFormat::kNv12, V4L2_PIX_FMT_NV12},
                                                               {PixelFormat::kNv12, V4L2_PIX_FMT_NV12M},
                                                               {PixelFormat::kMjpeg, V4L2_PIX_FMT_MJPEG},
                                                               {PixelFormat::kMjpeg, V4L2_PIX_FMT_JPEG}}};

std::optional<PixelFormat> format_of(__u32 code) {
  for (const auto& [format, known] : kCodes) {
    if (known == code) {
      return format;
    }
  }
  return std::nullopt;
}

// All values of an enumeration ioctl.
template <typename Request>
std::vector<Request> enumerate(const V4l2File& file, unsigned long code, Request request) {
  constexpr __u32 kMax = 256;  // Bounds the loop for drivers that never end.
  std::vector<Request> found;
  for (request.index = 0; request.index < kMax && file.call(code, &request) == 0; ++request.index) {
    found.push_back(request);
  }
  return found;
}

std::vector<v4l2_fmtdesc> offered_formats(const V4l2File& file, const V4l2Node& node) {
  v4l2_fmtdesc request{};
  request.type = v4l2_buffer_type(node);
  return enumerate(file, VIDIOC_ENUM_FMT, request);
}

__u32 code_of(PixelFormat format, const std::vector<v4l2_fmtdesc>& offered) {
  std::optional<__u32> chosen;
  for (const auto& known : kCodes) {
    const auto is_known = [&known](const v4l2_fmtdesc& other) { return other.pixelformat == known.second; };
    if (known.first == format && (!chosen || std::any_of(offered.begin(), offered.end(), is_known))) {
      chosen = known.second;
    }
  }
  return *chosen;
}

std::string code_text(__u32 code) {
  constexpr __u32 kByte = 0xff;
  std::string text;
  for (__u32 rest = code; rest != 0; rest >>= 8) {
    text += static_cast<char>(rest & kByte);
  }
  return text;
}

// The part of v4l2_format that the single- and the multi-planar interface share.
struct Mode {
  __u32 code = 0;
  __u32 width = 0;
  __u32 height = 0;
  __u32 field = V4L2_FIELD_NONE;
  __u32 stride = 0;
};

std::string described(const Mode& mode) {
  return concat(code_text(mode.code), " ", size_text(static_cast<int>(mode.width), static_cast<int>(mode.height)));
}

v4l2_format as_request(const Mode& mode, __u32 type) {
  v4l2_format request{};
  request.type = type;
  if (type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE) {
    request.fmt.pix_mp.pixelformat = mode.code;
    request.fmt.pix_mp.width = mode.width;
    request.fmt.pix_mp.height = mode.height;
    request.fmt.pix_mp.field = mode.field;
  } else {
    request.fmt.pix.pixelformat = mode.code;
    request.fmt.pix.width = mode.width;
    request.fmt.pix.height = mode.height;
    request.fmt.pix.field = mode.field;
  }
  return request;
}

Mode as_mode(const v4l2_format& format) {
  if (format.type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE) {
    const v4l2_pix_format_mplane& pixels = format.fmt.pix_mp;
    return {pixels.pixelformat, pixels.width, pixels.height, pixels.field, pixels.plane_fmt[0].bytesperline};
  }
  const v4l2_pix_format& pixels = format.fmt.pix;
  return {pixels.pixelformat, pixels.width, pixels.height, pixels.field, pixels.bytesperline};
}

// Modes of the requested format, or of all formats if that has none.
std::string offered(const V4l2File& file, const V4l2Node& node, PixelFormat format) {
  const std::vector<std::string> modes = list_v4l2_modes(file, node);
  std::vector<std::string> fitting;
  std::copy_if(modes.begin(), modes.end(), std::back_inserter(fitting),
               [format](const std::string& mode) { return mode.starts_with(to_string(format)); });
  const std::vector<std::string>& shown = fitting.empty() ? modes : fitting;
  return shown.empty() ? "it has no mode that Kinetrace can use" : "it can: " + listed(shown);
}

Result<Mode> set_format(const V4l2File& file, const V4l2Node& node, const CaptureConfig& config) {
  const Mode asked{.code = code_of(config.format, offered_formats(file, node)),
                   .width = static_cast<__u32>(config.width_px),
                   .height = static_cast<__u32>(config.height_px)};
  v4l2_format request = as_request(asked, v4l2_buffer_type(node));
  if (const Status set = file.require(VIDIOC_S_FMT, &request, "setting the format"); !set) {
    return Unexpected(set.error());
  }
  const Mode got = as_mode(request);
  if (got.width != asked.width || got.height != asked.height || format_of(got.code) != config.format) {
    return fail(ErrorCode::kUnsupported, concat(node.described(), ": asked for ", described(asked), ", the driver set ",
                                                described(got), "; ", offered(file, node, config.format)));
  }
  // Interlaced fields come from two moments.
  if (got.field != V4L2_FIELD_NONE && got.field != V4L2_FIELD_ANY) {
    return fail(ErrorCode::kUnsupported,
                concat(node.described(), ": delivers interlaced images in ", described(got), "; choose another mode"));
  }
  return got;
}

double rate_of(const v4l2_fract& interval) {
  return interval.numerator == 0 ? 0.0 : static_cast<double>(interval.denominator) / interval.numerator;
}

v4l2_fract interval_of(double rate_hz) {
  constexpr double kTicks = 1e7;  // 100 ns, the unit of USB cameras.
  const double whole = std::round(rate_hz);
  if (whole == rate_hz) {
    return {1, static_cast<__u32>(whole)};
  }
  return {static_cast<__u32>(std::lround(kTicks / rate_hz)), static_cast<__u32>(kTicks)};
}

// Zero if the device does not report its rate.
Result<double> set_rate(const V4l2File& file, const V4l2Node& node, const CaptureConfig& config) {
  constexpr double kTolerance = 0.01;  // 29.97 is often called 30.
  v4l2_streamparm request{};
  request.type = v4l2_buffer_type(node);
  request.parm.capture.timeperframe = interval_of(config.rate_hz);
  if (file.call(VIDIOC_S_PARM, &request) != 0 || (request.parm.capture.capability & V4L2_CAP_TIMEPERFRAME) == 0) {
    if (file.gone()) {
      return Unexpected(file.error(ENODEV, "setting the rate"));
    }
    return 0.0;
  }
  const double got_hz = rate_of(request.parm.capture.timeperframe);
  if (std::abs(got_hz - config.rate_hz) > kTolerance * config.rate_hz) {
    return fail(ErrorCode::kUnsupported,
                concat(node.described(), ": asked for ", number(config.rate_hz), " Hz, the driver set ", number(got_hz),
                       " Hz; ", offered(file, node, config.format)));
  }
  return got_hz;
}

std::string rates_text(const V4l2File& file, __u32 code, __u32 width, __u32 height) {
  v4l2_frmivalenum request{};
  request.pixel_format = code;
  request.width = width;
  request.height = height;
  std::vector<std::string> rates;
  for (const v4l2_frmivalenum& interval : enumerate(file, VIDIOC_ENUM_FRAMEINTERVALS, request)) {
    if (interval.type != V4L2_FRMIVAL_TYPE_DISCRETE) {
      return concat(" at ", number(rate_of(interval.stepwise.max)), " to ", number(rate_of(interval.stepwise.min)),
                    " Hz");
    }
    rates.push_back(number(rate_of(interval.discrete)));
  }
  return rates.empty() ? "" : concat(" at ", listed(rates, rates.size()), " Hz");
}

std::string mode_text(const V4l2File& file, std::string_view format, const v4l2_frmsizeenum& size) {
  const auto text = [](__u32 width, __u32 height) {
    return size_text(static_cast<int>(width), static_cast<int>(height));
  };
  if (size.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
    return concat(format, " ", text(size.discrete.width, size.discrete.height),
                  rates_text(file, size.pixel_format, size.discrete.width, size.discrete.height));
  }
  const v4l2_frmsize_stepwise& range = size.stepwise;
  return concat(format, " ", text(range.min_width, range.min_height), " to ", text(range.max_width, range.max_height),
                " in steps of ", text(range.step_width, range.step_height));
}

}  // namespace

std::uint32_t v4l2_buffer_type(const V4l2Node& node) noexcept {
  return node.multi_planar ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE;
}

Status set_v4l2_mode(const V4l2File& file, const V4l2Node& node, const CaptureConfig& config, CaptureInfo& info) {
  const Result<Mode> mode = set_format(file, node, config);
  if (!mode) {
    return Unexpected(mode.error());
  }
  const Result<double> rate_hz = set_rate(file, node, config);
  if (!rate_hz) {
    return Unexpected(rate_hz.error());
  }
  info.format = config.format;
  info.width_px = config.width_px;
  info.height_px = config.height_px;
  info.stride_bytes = config.format == PixelFormat::kMjpeg ? 0 : static_cast<int>(mode->stride);
  info.rate_hz = *rate_hz;
  return {};
}

std::vector<std::string> list_v4l2_modes(const V4l2File& file, const V4l2Node& node) {
  std::vector<std::string> modes;
  const std::vector<v4l2_fmtdesc> offered = offered_formats(file, node);
  for (const v4l2_fmtdesc& description : offered) {
    const auto format = format_of(description.pixelformat);
    if (!format || description.pixelformat != code_of(*format, offered)) {
      continue;
    }
    v4l2_frmsizeenum sizes{};
    sizes.pixel_format = description.pixelformat;
    for (const v4l2_frmsizeenum& size : enumerate(file, VIDIOC_ENUM_FRAMESIZES, sizes)) {
      modes.push_back(mode_text(file, to_string(*format), size));
    }
  }
  return modes;
}

}  // namespace kinetrace::hal
