#pragma once

#include <mpi.h>

#include <cstdint>
#include <string>

namespace bedload {

/// Finaliser of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014): every bit of the input changes about
/// half the bits of the result.
constexpr std::uint64_t scramble(std::uint64_t word) {
  word = (word ^ (word >> 30)) * 0xbf58476d1ce4e5b9u;
  word = (word ^ (word >> 27)) * 0x94d049bb133111ebu;
  return word ^ (word >> 31);
}

/// One word's part of the check sum of a file,  sum_n scramble(word_n + (n + 1) g)  mod 2^64, with
/// g = 2^64 / golden ratio. The sum does not care who adds which word, so ranks share the reading;
/// the place n of a word counts, so exchanged or shifted blocks show.
constexpr std::uint64_t checksum_term(std::uint64_t word, std::uint64_t n) {
  return scramble(word + (n + 1) * 0x9e3779b97f4a7c15u);
}

/// Check sum of the file from byte `first` to its end, the last word filled up with zeros.
/// Collective; every rank reads its share. Throws UserError on all ranks.
std::uint64_t file_checksum(const std::string& path, std::uint64_t first, MPI_Comm comm);

}  // namespace bedload
