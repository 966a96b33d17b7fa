// SPDX-License-Identifier: Apache-2.0
// Outcome of an operation that the world can make fail: peers, files, flags, full disks.
//
// A Status is either ok or a code with one line for a person: what happened, to which file or peer,
// and what to do. Result<T> is a value or a Status that is not ok. Neither can be ignored.
// What only a bug can do is a check instead (check.h).
//
// Threads. Plain values; no shared state.
#pragma once

#include <cstdlib>
#include <optional>
#include <string>
#include <utility>

namespace tessera {

enum class StatusCode {
  kOk,
  kInvalidArgument,    // the caller's or user's words are wrong; exit code 2 when from the command
                       // line
  kNotFound,           // file, name or peer does not exist
  kPermissionDenied,   // credentials or file rights
  kDataLoss,           // bytes damaged or malformed
  kResourceExhausted,  // a stated limit was reached
  kUnavailable,        // peer gone or not there yet; trying again may help
  kDeadlineExceeded,   // a deadline passed
  kCancelled,          // given up on request
  kClosed,             // the object was shut down
  kUnimplemented,      // this build cannot do it
  kInternal,           // a broken promise of our own, reported instead of aborted
};

class [[nodiscard]] Status {
 public:
  Status() = default;
  Status(StatusCode code, std::string message) : code_(code), message_(std::move(message)) {}

  static Status ok() { return {}; }
  static Status invalid_argument(std::string m) {
    return {StatusCode::kInvalidArgument, std::move(m)};
  }
  static Status not_found(std::string m) { return {StatusCode::kNotFound, std::move(m)}; }
  static Status permission_denied(std::string m) {
    return {StatusCode::kPermissionDenied, std::move(m)};
  }
  static Status data_loss(std::string m) { return {StatusCode::kDataLoss, std::move(m)}; }
  static Status resource_exhausted(std::string m) {
    return {StatusCode::kResourceExhausted, std::move(m)};
  }
  static Status unavailable(std::string m) { return {StatusCode::kUnavailable, std::move(m)}; }
  static Status deadline_exceeded(std::string m) {
    return {StatusCode::kDeadlineExceeded, std::move(m)};
  }
  static Status cancelled(std::string m) { return {StatusCode::kCancelled, std::move(m)}; }
  static Status closed(std::string m) { return {StatusCode::kClosed, std::move(m)}; }
  static Status unimplemented(std::string m) { return {StatusCode::kUnimplemented, std::move(m)}; }
  static Status internal(std::string m) { return {StatusCode::kInternal, std::move(m)}; }

  bool is_ok() const { return code_ == StatusCode::kOk; }
  StatusCode code() const { return code_; }
  const std::string& message() const { return message_; }

 private:
  StatusCode code_ = StatusCode::kOk;
  std::string message_;
};

template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : value_(std::move(value)) {}  // NOLINT(google-explicit-constructor)
  // Requires: status is not ok.
  Result(Status status) : status_(std::move(status)) {  // NOLINT(google-explicit-constructor)
    if (status_.is_ok()) std::abort();
  }

  bool is_ok() const { return value_.has_value(); }
  const Status& status() const { return status_; }

  // Requires: is_ok().
  T& value() & { return *value_; }
  const T& value() const& { return *value_; }
  T&& value() && { return std::move(*value_); }
  T& operator*() & { return *value_; }
  const T& operator*() const& { return *value_; }
  T&& operator*() && { return std::move(*value_); }
  T* operator->() { return &*value_; }
  const T* operator->() const { return &*value_; }

 private:
  Status status_;
  std::optional<T> value_;
};

}  // namespace tessera

// Hands a failed Status of `expression` to the caller.
#define TESSERA_RETURN_IF_ERROR(expression)                                         \
  do {                                                                              \
    if (::tessera::Status status_ = (expression); !status_.is_ok()) return status_; \
  } while (false)
