// tests/core/base/printable_text_test.cpp: text from outside cannot drive a terminal.
#include "core/base/shown_text.h"

#include "core/base/error.h"

#include <gtest/gtest.h>
#include <string>

namespace tessera {
namespace {

TEST(PrintableText, KeepsWordsAndEscapesWhatATerminalObeys) {
    EXPECT_EQ(printable("Thorax 1,0 µm \\ B30f \"é\" 頭 🫁"), "Thorax 1,0 µm \\ B30f \"é\" 頭 🫁");
    EXPECT_EQ(printable("\x1b]0;title\x07\x1b[2J"), "\\x1b]0;title\\x07\\x1b[2J");
    EXPECT_EQ(printable("a\nb\tc\r"), "a\\x0ab\\x09c\\x0d");
    EXPECT_EQ(printable(std::string("a\0b", 3)), "a\\x00b");
    EXPECT_EQ(printable("\x7f"), "\\x7f");
    EXPECT_EQ(printable("\xc2\x9b"
                        "31m"),
              "\\x9b31m")
        << "CSI as one character";
    EXPECT_EQ(printable("\xe2\x80\xae"
                        "gnp.exe"),
              "\\u202egnp.exe")
        << "right to left from here on";
    EXPECT_EQ(printable(""), "");
}

// Marks, embeddings, overrides, isolates and separators of lines, each from its first to its last.
TEST(PrintableText, EscapesAllThatMovesText) {
    const auto utf8 = [](unsigned code) {
        std::string text;
        if (code >= 0x800)
            text = {static_cast<char>(0xe0 | code >> 12), static_cast<char>(0x80 | (code >> 6 & 0x3f))};
        else
            text = {static_cast<char>(0xc0 | code >> 6)};
        return text + static_cast<char>(0x80 | (code & 0x3f));
    };
    for (unsigned code = 0xa0; code < 0xd800; ++code) {
        const bool moves = code == 0x61c || code == 0x200e || code == 0x200f ||
                           (code >= 0x2028 && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
        EXPECT_EQ(printable(utf8(code)) == utf8(code), !moves) << code;
    }
}

TEST(PrintableText, EscapesWhatIsNoUtf8) {
    EXPECT_EQ(printable("\x9b"
                        "2J"),
              "\\x9b2J");
    EXPECT_EQ(printable("M\xfcller"), "M\\xfcller") << "Latin-1";
    EXPECT_EQ(printable("\xc3"), "\\xc3") << "cut short";
    EXPECT_EQ(printable("\xe0\x80\x9b"), "\\xe0\\x80\\x9b") << "overlong";
    EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80") << "half of a surrogate pair";
    EXPECT_EQ(printable("\xf5\x80\x80\x80"), "\\xf5\\x80\\x80\\x80");
}

TEST(PrintableText, LinesMayStay) {
    EXPECT_EQ(printableLines("one\ntwo\x1b"), "one\ntwo\\x1b");
}

TEST(PrintableText, ABadFilesNameIsOneLineOfAMessage) {
    EXPECT_STREQ(badFile("a\nwrote b.png", "a store", "none").what(),
                 "a\\x0awrote b.png: expected a store, found none");
}

} // namespace
} // namespace tessera
