// A value or an error. The part of C++23's std::expected that is used here, so that headers need nothing but the
// standard library and Eigen.
#pragma once

#include <functional>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>

namespace kinetrace {

/// Marks a value as an error: `return Unexpected(error);`.
template <typename E>
class Unexpected {
 public:
  explicit constexpr Unexpected(E error) : error_(std::move(error)) {}

  [[nodiscard]] constexpr const E& error() const& noexcept { return error_; }
  [[nodiscard]] constexpr E&& error() && noexcept { return std::move(error_); }

 private:
  E error_;
};

/// A T, or an E that says why there is none. Reading the value of a failure, or the error of a success, with `*`, `->`
/// or `error()` is undefined; `value()` throws std::bad_variant_access instead.
template <typename T, typename E>
class [[nodiscard]] Expected {
 public:
  using value_type = T;
  using error_type = E;

  constexpr Expected() requires std::is_default_constructible_v<T>
  = default;

  template <typename U = T>
  requires(std::is_constructible_v<T, U> && !std::is_same_v<std::remove_cvref_t<U>, Expected>)
      // NOLINTNEXTLINE(google-explicit-constructor,bugprone-forwarding-reference-overload): a value is a success.
      constexpr explicit(!std::is_convertible_v<U, T>) Expected(U&& value)
      : outcome_(std::in_place_index<0>, std::forward<U>(value)) {}

  template <typename G>
  requires std::is_constructible_v<E, G>
  // NOLINTNEXTLINE(google-explicit-constructor): a reason is a failure.
  constexpr Expected(Unexpected<G> reason) : outcome_(std::in_place_index<1>, std::move(reason).error()) {}

  /// Converts the value (such as a pointer to a derived class), or passes the failure on.
  template <typename U>
  requires(std::is_convertible_v<U, T> && !std::is_same_v<U, T>)
      // NOLINTNEXTLINE(google-explicit-constructor): as the values convert.
      constexpr Expected(Expected<U, E>&& other)
      : outcome_(other.has_value() ? decltype(outcome_)(std::in_place_index<0>, *std::move(other))
                                   : decltype(outcome_)(std::in_place_index<1>, std::move(other).error())) {}

  [[nodiscard]] constexpr bool has_value() const noexcept { return outcome_.index() == 0; }
  [[nodiscard]] constexpr explicit operator bool() const noexcept { return has_value(); }

  [[nodiscard]] constexpr T& operator*() & noexcept { return *std::get_if<0>(&outcome_); }
  [[nodiscard]] constexpr const T& operator*() const& noexcept { return *std::get_if<0>(&outcome_); }
  [[nodiscard]] constexpr T&& operator*() && noexcept { return std::move(*std::get_if<0>(&outcome_)); }
  [[nodiscard]] constexpr T* operator->() noexcept { return std::get_if<0>(&outcome_); }
  [[nodiscard]] constexpr const T* operator->() const noexcept { return std::get_if<0>(&outcome_); }

  [[nodiscard]] constexpr T& value() & { return std::get<0>(outcome_); }
  [[nodiscard]] constexpr const T& value() const& { return std::get<0>(outcome_); }
  [[nodiscard]] constexpr T&& value() && { return std::get<0>(std::move(outcome_)); }
  template <typename U>
  [[nodiscard]] constexpr T value_or(U&& fallback) const& {
    return has_value() ? **this : static_cast<T>(std::forward<U>(fallback));
  }
  template <typename U>
  [[nodiscard]] constexpr T value_or(U&& fallback) && {
    return has_value() ? std::move(**this) : static_cast<T>(std::forward<U>(fallback));
  }

  [[nodiscard]] constexpr E& error() & noexcept { return *std::get_if<1>(&outcome_); }
  [[nodiscard]] constexpr const E& error() const& noexcept { return *std::get_if<1>(&outcome_); }
  [[nodiscard]] constexpr E&& error() && noexcept { return std::move(*std::get_if<1>(&outcome_)); }

  /// `next(value)`, itself an Expected with the same kind of error, or this failure.
  template <typename Next>
  [[nodiscard]] constexpr auto and_then(Next&& next) const -> std::invoke_result_t<Next, const T&> {
    if (!has_value()) {
      return Unexpected<E>(error());
    }
    return std::invoke(std::forward<Next>(next), **this);
  }
  /// Success with `change(value)`, or this failure.
  template <typename Change>
  [[nodiscard]] constexpr auto transform(Change&& change) const
      -> Expected<std::remove_cvref_t<std::invoke_result_t<Change, const T&>>, E> {
    if (!has_value()) {
      return Unexpected<E>(error());
    }
    return std::invoke(std::forward<Change>(change), **this);
  }

 private:
  std::variant<T, E> outcome_;
};

/// Success, or an E that says why not.
template <typename E>
class [[nodiscard]] Expected<void, E> {
 public:
  using value_type = void;
  using error_type = E;

  constexpr Expected() = default;
  template <typename G>
  requires std::is_constructible_v<E, G>
  // NOLINTNEXTLINE(google-explicit-constructor): a reason is a failure.
  constexpr Expected(Unexpected<G> reason) : error_(std::move(reason).error()) {}

  [[nodiscard]] constexpr bool has_value() const noexcept { return !error_.has_value(); }
  [[nodiscard]] constexpr explicit operator bool() const noexcept { return has_value(); }

  [[nodiscard]] constexpr E& error() & noexcept { return *error_; }
  [[nodiscard]] constexpr const E& error() const& noexcept { return *error_; }
  [[nodiscard]] constexpr E&& error() && noexcept { return *std::move(error_); }

 private:
  std::optional<E> error_;
};

}  // namespace kinetrace
