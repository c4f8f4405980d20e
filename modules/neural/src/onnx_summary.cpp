#include "onnx_summary.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "kinetrace/core/files.hpp"

namespace kinetrace::neural {
namespace {

/// Decodes a varint from the front (seven bits a byte, least significant first); none if it does not end.
std::optional<std::uint64_t> take_varint(std::string_view& rest) {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < 64 && !rest.empty(); shift += 7) {
    const auto byte = static_cast<std::uint8_t>(rest.front());
    rest.remove_prefix(1);
    value |= static_cast<std::uint64_t>(byte & 0x7FU) << shift;
    if (byte < 0x80U) {
      return value;
    }
  }
  return std::nullopt;
}

/// The fields of one message of the Protocol Buffers wire format.
class Fields {
 public:
  struct Field {
    std::uint64_t number = 0;
    std::uint64_t value = 0;  ///< Of a varint.
    std::string_view bytes;   ///< Of a length-delimited field, or a fixed one.
  };

  explicit Fields(std::string_view message) : rest_(message) {}

  /// None at the end, or if the message is damaged.
  std::optional<Field> next() {
    const std::optional<std::uint64_t> key = varint();
    if (!key) {
      return std::nullopt;
    }
    Field field{.number = *key >> 3U, .value = 0, .bytes = {}};
    switch (*key & 7U) {
      case 0: {
        const std::optional<std::uint64_t> value = varint();
        field.value = value.value_or(0);
        return value ? std::optional(field) : damaged();
      }
      case 1: return take(8, field);
      case 2: {
        const std::optional<std::uint64_t> length = varint();
        return length ? take(*length, field) : damaged();
      }
      case 5: return take(4, field);
      default: return damaged();
    }
  }
  [[nodiscard]] bool is_damaged() const noexcept { return is_damaged_; }

 private:
  std::optional<Field> damaged() {
    is_damaged_ = true;
    return std::nullopt;
  }
  std::optional<Field> take(std::uint64_t length, Field& field) {
    if (length > rest_.size()) {
      return damaged();
    }
    field.bytes = rest_.substr(0, static_cast<std::size_t>(length));
    rest_.remove_prefix(field.bytes.size());
    return field;
  }
  std::optional<std::uint64_t> varint() {
    const bool had_any = !rest_.empty();
    const std::optional<std::uint64_t> value = take_varint(rest_);
    is_damaged_ = is_damaged_ || (had_any && !value);
    return value;
  }

  std::string_view rest_;
  bool is_damaged_ = false;
};

using Field = Fields::Field;

// Field numbers of onnx.proto3.
namespace model_field {
constexpr std::uint64_t kGraph = 7, kOpsetImport = 8;
}
namespace opset_field {
constexpr std::uint64_t kDomain = 1, kVersion = 2;
}
namespace graph_field {
constexpr std::uint64_t kNode = 1, kInitializer = 5, kInput = 11;
}
namespace node_field {
constexpr std::uint64_t kInput = 1, kOutput = 2, kOperator = 4, kAttribute = 5;
}
namespace attribute_field {
constexpr std::uint64_t kTensor = 5;
}
namespace tensor_field {
constexpr std::uint64_t kType = 2, kFloats = 4, kInts = 7, kName = 8, kRaw = 9;
}
namespace value_field {
constexpr std::uint64_t kName = 1, kType = 2;
}
constexpr std::uint64_t kFloatTensor = 1;
constexpr std::uint64_t kInt64Tensor = 7;

template <typename T>
std::vector<T> values_of(std::string_view bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  // copy_n, since an empty tensor may have null pointers, which memcpy forbids.
  std::copy_n(bytes.data(), values.size() * sizeof(T), reinterpret_cast<char*>(values.data()));
  return values;
}

struct OnnxTensor {
  std::string name;
  bool is_finite = true;
  std::vector<std::int64_t> ints;
};

struct OnnxNode {
  std::string type;
  std::vector<std::string> inputs;
  std::string output;
  OnnxTensor constant;
};

class Reader {
 public:
  [[nodiscard]] bool read_model(std::string_view bytes) {
    return each(bytes,
                [&](const Field& field) {
                  if (field.number == model_field::kGraph) {
                    has_graph_ = true;
                    return read_graph(field.bytes);
                  }
                  return field.number != model_field::kOpsetImport || read_opset(field.bytes);
                }) &&
           has_graph_;
  }

  [[nodiscard]] OnnxSummary summary() {
    std::set<std::string> operators;
    for (const OnnxNode& node : nodes_) {
      operators.insert(node.type);
      summary_.has_uneven_split = summary_.has_uneven_split || splits_unevenly(node);
    }
    summary_.operators.assign(operators.begin(), operators.end());
    return summary_;
  }

 private:
  template <typename Visit>
  static bool each(std::string_view message, Visit&& visit) {
    Fields fields(message);
    while (const std::optional<Field> field = fields.next()) {
      if (!visit(*field)) {
        return false;
      }
    }
    return !fields.is_damaged();
  }

  bool read_opset(std::string_view bytes) {
    std::int64_t version = 0;
    bool is_default_domain = true;
    const bool fine = each(bytes, [&](const Field& field) {
      if (field.number == opset_field::kVersion) {
        version = static_cast<std::int64_t>(field.value);
      } else if (field.number == opset_field::kDomain) {
        is_default_domain = field.bytes.empty() || field.bytes == "ai.onnx";
      }
      return true;
    });
    summary_.opset = is_default_domain ? version : summary_.opset;
    return fine;
  }

  bool read_graph(std::string_view bytes) {
    std::vector<std::pair<std::string, std::vector<std::int64_t>>> inputs;
    const bool fine = each(bytes, [&](const Field& field) {
      switch (field.number) {
        case graph_field::kNode: return read_node(field.bytes);
        case graph_field::kInitializer: return read_initializer(field.bytes);
        case graph_field::kInput: return read_input(field.bytes, inputs);
        default: return true;
      }
    });
    // Older files list weights among the inputs.
    const auto first = std::find_if(inputs.begin(), inputs.end(),
                                    [&](const auto& input) { return !constants_.contains(input.first); });
    if (first != inputs.end()) {
      summary_.input = first->second;
    }
    return fine;
  }

  bool read_node(std::string_view bytes) {
    OnnxNode node;
    const bool fine = each(bytes, [&](const Field& field) {
      switch (field.number) {
        case node_field::kInput: node.inputs.emplace_back(field.bytes); return true;
        case node_field::kOutput:
          node.output = node.output.empty() ? std::string(field.bytes) : node.output;
          return true;
        case node_field::kOperator: node.type = field.bytes; return true;
        case node_field::kAttribute:
          return each(field.bytes, [&](const Field& attribute) {
            return attribute.number != attribute_field::kTensor || read_tensor(attribute.bytes, node.constant);
          });
        default: return true;
      }
    });
    if (node.type == "Constant") {
      node.constant.name = node.output;
      keep(node.constant);
    }
    nodes_.push_back(std::move(node));
    return fine;
  }

  bool read_initializer(std::string_view bytes) {
    OnnxTensor tensor;
    const bool fine = read_tensor(bytes, tensor);
    keep(tensor);
    return fine;
  }

  static bool read_tensor(std::string_view bytes, OnnxTensor& tensor) {
    std::uint64_t type = 0;
    std::string_view raw;
    std::string_view floats;
    const bool fine = each(bytes, [&](const Field& field) {
      switch (field.number) {
        case tensor_field::kType: type = field.value; return true;
        case tensor_field::kName: tensor.name = field.bytes; return true;
        case tensor_field::kRaw: raw = field.bytes; return true;
        case tensor_field::kFloats: floats = field.bytes; return true;
        case tensor_field::kInts: return read_ints(field, tensor.ints);
        default: return true;
      }
    });
    if (type == kInt64Tensor && !raw.empty()) {
      tensor.ints = values_of<std::int64_t>(raw);
    }
    if (type == kFloatTensor) {
      const std::vector<float> values = values_of<float>(raw.empty() ? floats : raw);
      tensor.is_finite = std::all_of(values.begin(), values.end(), [](float value) { return std::isfinite(value); });
    }
    return fine;
  }

  // Accepts packed and unpacked encoding.
  static bool read_ints(const Field& field, std::vector<std::int64_t>& ints) {
    if (field.bytes.empty()) {
      ints.push_back(static_cast<std::int64_t>(field.value));
      return true;
    }
    for (std::string_view rest = field.bytes; !rest.empty();) {
      const std::optional<std::uint64_t> value = take_varint(rest);
      if (!value) {
        return false;
      }
      ints.push_back(static_cast<std::int64_t>(*value));
    }
    return true;
  }

  static bool read_input(std::string_view bytes,
                         std::vector<std::pair<std::string, std::vector<std::int64_t>>>& inputs) {
    std::string name;
    std::vector<std::int64_t> sizes;
    const auto read_dimension = [&](std::string_view dimension) {
      sizes.push_back(0);
      return each(dimension, [&](const Field& field) {
        sizes.back() = field.number == 1 ? static_cast<std::int64_t>(field.value) : sizes.back();
        return true;
      });
    };
    // TypeProto.tensor_type (1) . shape (2) . dim (1)
    const bool fine = each(bytes, [&](const Field& value) {
      if (value.number == value_field::kName) {
        name = value.bytes;
      }
      return value.number != value_field::kType || each(value.bytes, [&](const Field& type) {
               return type.number != 1 || each(type.bytes, [&](const Field& tensor) {
                        return tensor.number != 2 || each(tensor.bytes, [&](const Field& shape) {
                                 return shape.number != 1 || read_dimension(shape.bytes);
                               });
                      });
             });
    });
    inputs.emplace_back(name, sizes);
    return fine;
  }

  void keep(const OnnxTensor& tensor) {
    if (!tensor.is_finite && summary_.weights_not_finite.empty()) {
      summary_.weights_not_finite = tensor.name;
    }
    constants_[tensor.name] = tensor.ints;
  }

  [[nodiscard]] bool splits_unevenly(const OnnxNode& node) const {
    if (node.type != "Split" || node.inputs.size() < 2) {
      return false;
    }
    const auto sizes = constants_.find(node.inputs[1]);
    return sizes != constants_.end() &&
           std::adjacent_find(sizes->second.begin(), sizes->second.end(), std::not_equal_to<>()) != sizes->second.end();
  }

  OnnxSummary summary_;
  bool has_graph_ = false;
  std::vector<OnnxNode> nodes_;
  std::map<std::string, std::vector<std::int64_t>> constants_;
};

}  // namespace

Result<OnnxSummary> summarize_onnx(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) {
    return unreachable(file, "there is no such model");
  }
  const std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (in.bad()) {
    return fail(ErrorCode::kIo, file + ": cannot be read");
  }
  Reader reader;
  if (!reader.read_model(bytes)) {
    return fail(ErrorCode::kBadFormat, file + ": not an ONNX model, or only a part of one; export or copy it again");
  }
  return reader.summary();
}

}  // namespace kinetrace::neural
