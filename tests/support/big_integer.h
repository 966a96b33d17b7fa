// SPDX-License-Identifier: Apache-2.0
// Integers of up to 1,088 bits, by schoolbook arithmetic: what an oracle of exact answers computes
// with. A float is such an integer times a power of two, and so is everything that is added and
// multiplied from floats: coordinates of one exponent have at most 278 bits, a difference of them
// one more, and a sum of 6 products of three of these 840.
//
// Threads. Values.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>

namespace tessera::test {

class BigInteger {
 public:
  BigInteger() = default;
  // Requires: value is an integer times 2^exponent.
  BigInteger(float value, int exponent) {
    int own = 0;
    const float share = std::frexp(std::fabs(value), &own);
    if (share == 0) return;
    auto mantissa = static_cast<std::uint64_t>(std::ldexp(share, 24));
    int shift = own - 24 - exponent;
    for (; shift < 0; ++shift) mantissa >>= 1;  // zeros, by the requirement
    const auto whole = static_cast<unsigned>(shift) / 64, part = static_cast<unsigned>(shift) % 64;
    limbs_[whole] = mantissa << part;
    limbs_[whole + 1] = part == 0 ? 0 : mantissa >> (64 - part);
    for (unsigned k = 0; k < whole; ++k) limbs_[k] = 0;
    trim(static_cast<int>(whole) + 2);
    is_negative_ = value < 0;
  }

  int sign() const { return size_ == 0 ? 0 : is_negative_ ? -1 : 1; }

  BigInteger operator-() const {
    BigInteger result = *this;
    result.is_negative_ = !is_negative_;
    return result;
  }
  friend BigInteger operator+(const BigInteger& a, const BigInteger& b) {
    if (a.is_negative_ == b.is_negative_) return a.plus(b);
    return a.is_less(b) ? b.minus(a) : a.minus(b);
  }
  friend BigInteger operator-(const BigInteger& a, const BigInteger& b) { return a + -b; }
  friend BigInteger operator*(const BigInteger& a, const BigInteger& b) {
    BigInteger product;
    if (a.size_ == 0 || b.size_ == 0) return product;
    check(a.size_ + b.size_);
    for (int k = 0; k < a.size_ + b.size_; ++k) product.limbs_[k] = 0;
    for (int i = 0; i < a.size_; ++i) {
      std::uint64_t carry = 0;
      for (int j = 0; j < b.size_; ++j) {
        const Wide sum = Wide{a.limbs_[i]} * b.limbs_[j] + product.limbs_[i + j] + carry;
        product.limbs_[i + j] = static_cast<std::uint64_t>(sum);
        carry = static_cast<std::uint64_t>(sum >> 64);
      }
      product.limbs_[i + b.size_] = carry;
    }
    product.trim(a.size_ + b.size_);
    product.is_negative_ = a.is_negative_ != b.is_negative_;
    return product;
  }
  friend bool operator==(const BigInteger& a, const BigInteger& b) { return (a - b).sign() == 0; }

  // Returns: this times 2^exponent, rounded to nearest, ties to even. Requires: it is within the
  // normal numbers of double, or zero.
  double in_double(int exponent) const {
    int shift = 0;
    const auto magnitude = static_cast<double>(leading(shift));
    return std::ldexp(is_negative_ ? -magnitude : magnitude, shift + exponent);
  }
  // Returns: this times 2^exponent to 2^-63. Requires: long double has 64 bits, and 15 of exponent.
  long double in_long_double(int exponent) const {
    int shift = 0;
    const auto magnitude = static_cast<long double>(leading(shift));
    return std::ldexp(is_negative_ ? -magnitude : magnitude, shift + exponent);
  }

 private:
  __extension__ using Wide = unsigned __int128;
  static constexpr int kLimbs = 17;

  static void check(int size) {
    if (size > kLimbs) std::abort();  // a bug of the oracle: it was given more than it has room for
  }
  void trim(int size) {
    while (size > 0 && limbs_[size - 1] == 0) --size;
    size_ = size;
  }
  std::uint64_t limb(int k) const { return k < size_ ? limbs_[k] : 0; }
  bool is_less(const BigInteger& other) const {  // by magnitude
    if (size_ != other.size_) return size_ < other.size_;
    for (int k = size_ - 1; k >= 0; --k) {
      if (limbs_[k] != other.limbs_[k]) return limbs_[k] < other.limbs_[k];
    }
    return false;
  }
  // The sum of magnitudes, of this sign.
  BigInteger plus(const BigInteger& other) const {
    BigInteger sum;
    const int size = size_ > other.size_ ? size_ : other.size_;
    check(size + 1);
    std::uint64_t carry = 0;
    for (int k = 0; k < size; ++k) {
      const Wide part = Wide{limb(k)} + other.limb(k) + carry;
      sum.limbs_[k] = static_cast<std::uint64_t>(part);
      carry = static_cast<std::uint64_t>(part >> 64);
    }
    sum.limbs_[size] = carry;
    sum.trim(size + 1);
    sum.is_negative_ = is_negative_;
    return sum;
  }
  // The difference of magnitudes, of this sign. Requires: `other` is not greater.
  BigInteger minus(const BigInteger& other) const {
    BigInteger difference;
    std::uint64_t borrow = 0;
    for (int k = 0; k < size_; ++k) {
      const Wide part = Wide{limbs_[k]} - other.limb(k) - borrow;
      difference.limbs_[k] = static_cast<std::uint64_t>(part);
      borrow = (part >> 64) != 0 ? 1 : 0;
    }
    difference.trim(size_);
    difference.is_negative_ = is_negative_;
    return difference;
  }
  // The 64 leading bits of the magnitude, which is about 2^shift times them. The last of them is
  // also set where one behind them is, so that rounding to fewer bits is that of the whole.
  std::uint64_t leading(int& shift) const {
    shift = 0;
    if (size_ == 0) return 0;
    const int zeros = std::countl_zero(limbs_[size_ - 1]);
    shift = 64 * (size_ - 1) - zeros;
    std::uint64_t bits = limbs_[size_ - 1] << zeros, rest = 0;
    if (size_ > 1 && zeros > 0) {
      bits |= limbs_[size_ - 2] >> (64 - zeros);
      rest = limbs_[size_ - 2] << zeros;
    } else if (size_ > 1) {
      rest = limbs_[size_ - 2];
    }
    for (int k = 0; k < size_ - 2; ++k) rest |= limbs_[k];
    return bits | (rest != 0 ? 1u : 0u);
  }

  std::uint64_t limbs_[kLimbs + 1] = {};  // the least first
  int size_ = 0;                          // limbs that count; the last of them is not 0
  bool is_negative_ = false;
};

}  // namespace tessera::test
