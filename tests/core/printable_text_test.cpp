// tests/core/printable_text_test.cpp: what comes from outside cannot drive a terminal.
#include "core/printable_text.h"

#include "core/error.h"

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
