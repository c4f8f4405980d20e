#include "kinetrace/geo/reference.hpp"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "nmea_sentence.hpp"
#include "temp_folder.hpp"
#include "utc_time.hpp"

namespace kinetrace::geo {
namespace {

using kinetrace::test::TempFolder;
using testing::HasSubstr;

class References : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) {
    const std::string path = folder_.file(name);
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }
  Result<Reference> read(ReferenceFormat format, const std::string& name, const std::string& text) {
    return read_reference({format, write(name, text), std::nullopt, 1'317'042'000LL * kSecond_ns});
  }
  Result<Reference> read_nmea(const std::string& text) { return read(ReferenceFormat::kNmea, "log.nmea", text); }

  TempFolder folder_;
};

/// `$BODY*hh`.
std::string sentence(const std::string& body) {
  unsigned sum = 0;
  for (const char c : body) {
    sum ^= static_cast<unsigned char>(c);
  }
  char text[8];
  std::snprintf(text, sizeof text, "*%02X\r\n", sum);
  return "$" + body + text;
}

std::string gga(const std::string& clock, double minutes = 0.66, int quality = 1) {
  char text[160];
  std::snprintf(text, sizeof text, "GPGGA,%s,49%07.4f,N,00824.9600,E,%d,09,0.9,68.4,M,48.0,M,,", clock.c_str(), minutes,
                quality);
  return sentence(text);
}

std::string rmc(const std::string& clock, const std::string& date) {
  return sentence("GPRMC," + clock + ",A,4900.6600,N,00824.9600,E,12.0,90.0," + date + ",,,A");
}

// The common example of receiver manuals.
TEST(NmeaSentence, ChecksTheSum) {
  const std::string line = "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47";
  const Sentence good = parse_sentence(line);
  EXPECT_EQ(good.state, SentenceState::kGood);
  EXPECT_EQ(good.type, "GGA");
  ASSERT_EQ(good.fields.size(), 14U);
  EXPECT_EQ(good.fields[0], "123519");
  EXPECT_EQ(parse_sentence("noise" + line).state, SentenceState::kGood);
  std::string wrong = line;
  wrong[20] = '9';
  EXPECT_EQ(parse_sentence(wrong).state, SentenceState::kBadChecksum);
  for (const char* cut : {"", "$", "*47", "$GP*47", "$GPGGA,1", "$GPGGA,1*", "$GPGGA,1*4", "$GPGGA,1*zz"}) {
    EXPECT_EQ(parse_sentence(cut).state, SentenceState::kMalformed) << cut;
  }
}

TEST(NmeaSentence, ReadsAnglesWithTheirHemisphere) {
  EXPECT_NEAR(*parse_angle_deg("4807.038", "N"), 48.1173, 1e-9);
  EXPECT_NEAR(*parse_angle_deg("01131.000", "W"), -11.516666667, 1e-9);
  EXPECT_NEAR(*parse_angle_deg("9000.0", "S"), -90.0, 1e-9);
  for (const auto& [value, hemisphere] : {std::pair{"4860.0", "N"},
                                          {"9000.1", "N"},
                                          {"18000.1", "E"},
                                          {"-100.0", "N"},
                                          {"", "N"},
                                          {"nan", "N"},
                                          {"4807.0", ""},
                                          {"4807.0", "X"}}) {
    EXPECT_FALSE(parse_angle_deg(value, hemisphere)) << value << hemisphere;
  }
}

TEST_F(References, NmeaHasTheDateOfRmcAndTheHeightAboveTheEllipsoid) {
  const auto reference = read_nmea(gga("130225.50") + rmc("130225.50", "260911") + gga("130226.50"));
  ASSERT_TRUE(reference) << reference.error().message;
  ASSERT_EQ(reference->fixes.size(), 2U);
  EXPECT_EQ(reference->fixes[0].time_ns, parse_date_time_ns("2011-09-26T13:02:25.5Z"));
  EXPECT_EQ(reference->fixes[1].time_ns, parse_date_time_ns("2011-09-26T13:02:26.5Z"));
  EXPECT_NEAR(reference->frame.origin().latitude_deg, 49.011, 1e-9);
  EXPECT_NEAR(reference->frame.origin().height_m, 116.4, 1e-9);
  EXPECT_TRUE(reference->notes.empty());
}

TEST_F(References, NmeaContinuesPastMidnight) {
  const auto reference = read_nmea(rmc("235959.00", "311211") + gga("235959.00") + gga("000000.00") +
                                   rmc("000000.00", "010112") + gga("000001.00"));
  ASSERT_TRUE(reference);
  ASSERT_EQ(reference->fixes.size(), 3U);
  EXPECT_EQ(reference->fixes[1].time_ns - reference->fixes[0].time_ns, kSecond_ns);
  EXPECT_EQ(reference->fixes[2].time_ns, parse_date_time_ns("2012-01-01T00:00:01Z"));
}

TEST_F(References, NmeaWithoutADateHasThatOfTheRecording) {
  const auto reference = read_nmea(gga("130225.00") + gga("130226.00") + gga("130227.00"));
  ASSERT_TRUE(reference);
  ASSERT_EQ(reference->fixes.size(), 3U);
  EXPECT_EQ(reference->fixes[0].time_ns, parse_date_time_ns("2011-09-26T13:02:25Z"));
  EXPECT_EQ(reference->fixes[2].time_ns, parse_date_time_ns("2011-09-26T13:02:27Z"));
  EXPECT_EQ(reference->counts.repeated, 0);
  ASSERT_EQ(reference->notes.size(), 1U);
  EXPECT_THAT(reference->notes[0], HasSubstr("no date"));
}

TEST_F(References, NmeaCountsWhatIsWrong) {
  std::string damaged = gga("130228.00");
  damaged[12] = '9';
  const auto reference = read_nmea(rmc("130225.00", "260911") + gga("130225.00") + gga("130226.00") + gga("130227.00") +
                                   damaged + "$GPGGA,1302\r\n" + gga("130229.00", 0.66, 0) + gga("130226.00") +
                                   gga("130235.00") + gga("130236.00", 0.90) + gga("130237.00", 0.90) + "\r\n");
  ASSERT_TRUE(reference) << reference.error().message;
  const ReferenceCounts& counts = reference->counts;
  EXPECT_EQ(counts.records, 11);
  EXPECT_EQ(counts.bad_checksums, 1);
  EXPECT_EQ(counts.malformed, 1);
  EXPECT_EQ(counts.without_fix, 1);
  EXPECT_EQ(counts.repeated, 1);
  EXPECT_EQ(counts.gaps, 1);
  EXPECT_DOUBLE_EQ(counts.longest_gap_s, 8.0);
  EXPECT_EQ(counts.jumps, 1);  // 445 m in a second.
  EXPECT_EQ(reference->fixes.size(), 6U);
}

// At a cold start receivers send the date that their clock begins with.
TEST_F(References, NmeaWithoutAFixHasNoDate) {
  const std::string cold = sentence("GPRMC,130224.90,V,,,,,,,060180,,,N");
  const auto reference = read_nmea(cold + gga("130225.00") + rmc("130225.00", "260911") + gga("130226.00"));
  ASSERT_TRUE(reference) << reference.error().message;
  ASSERT_EQ(reference->fixes.size(), 2U);
  EXPECT_EQ(reference->fixes[0].time_ns, parse_date_time_ns("2011-09-26T13:02:25Z"));
  EXPECT_EQ(reference->fixes[1].time_ns, parse_date_time_ns("2011-09-26T13:02:26Z"));
}

TEST_F(References, NoiseAtAHighRateIsNoJump) {
  std::string text = rmc("130225.00", "260911");
  for (int i = 0; i < 50; ++i) {
    char clock[16];
    std::snprintf(clock, sizeof clock, "130225.%02d", 2 * i);
    text += gga(clock, i % 2 == 0 ? 0.6600 : 0.6620);  // 3.7 m there and back within 20 ms.
  }
  EXPECT_EQ(read_nmea(text)->counts.jumps, 0);
}

TEST_F(References, NmeaWithoutAFixIsRefusedWithItsCounts) {
  const auto reference = read_nmea(gga("130225.00", 0.66, 0) + "$GPGGA\r\n");
  ASSERT_FALSE(reference);
  EXPECT_EQ(reference.error().code, ErrorCode::kBadFormat);
  EXPECT_THAT(reference.error().message, HasSubstr("1 are malformed"));
  EXPECT_THAT(reference.error().message, HasSubstr("1 say that there is no fix"));
  EXPECT_EQ(read_nmea("").error().code, ErrorCode::kBadFormat);
}

TEST_F(References, NmeaWithoutPositionsIsRefusedWithTheSentenceThatIsMissing) {
  const auto reference = read_nmea(rmc("130225.00", "260911"));
  ASSERT_FALSE(reference);
  EXPECT_THAT(reference.error().message, HasSubstr("no readable GGA"));
}

TEST_F(References, NmeaIsAsSureAsItsQualityAndDilutionSay) {
  const auto reference = read_nmea(rmc("130225.00", "260911") + gga("130225.00", 0.66, 1) + gga("130226.00", 0.66, 4));
  ASSERT_TRUE(reference);
  EXPECT_NEAR(reference->fixes[0].sigma_m.x(), 2.7, 1e-9);
  EXPECT_NEAR(reference->fixes[1].sigma_m.x(), 0.018, 1e-9);
  EXPECT_GT(reference->fixes[0].sigma_m.z(), reference->fixes[0].sigma_m.x());
}

std::string gpx(const std::string& points) {
  return "<?xml version=\"1.0\"?><gpx version=\"1.1\"><trk><trkseg>" + points + "</trkseg></trk></gpx>";
}

TEST_F(References, GpxHasTrackPointsWithTime) {
  const auto reference =
      read(ReferenceFormat::kGpx, "a.gpx",
           gpx("<trkpt lat=\"49.011\" lon=\"8.416\"><ele>116.4</ele><time>2011-09-26T13:02:25Z</time></trkpt>"
               "<trkpt lat=\"49.012\" "
               "lon=\"8.416\"><ele>68.4</ele><time>2011-09-26T13:02:27Z</time><geoidheight>48</geoidheight></trkpt>"
               "<trkpt lat=\"49.013\" lon=\"8.416\"><ele>116.4</ele></trkpt>"
               "<trkpt lat=\"99\" lon=\"8.416\"><ele>116.4</ele><time>2011-09-26T13:02:28Z</time></trkpt>"));
  ASSERT_TRUE(reference) << reference.error().message;
  ASSERT_EQ(reference->fixes.size(), 2U);
  EXPECT_EQ(reference->counts.malformed, 2);
  ASSERT_EQ(reference->notes.size(), 1U);
  EXPECT_THAT(reference->notes[0], HasSubstr("1 of 4 points have no <time>"));
  EXPECT_NEAR((reference->fixes[1].enu_m - reference->fixes[0].enu_m).y(), 111.2, 0.1);
  EXPECT_NEAR((reference->fixes[1].enu_m - reference->fixes[0].enu_m).z(), 0.0, 0.01);
}

TEST_F(References, GpxTracksMayComeNewestFirst) {
  const auto point = [](const std::string& second, const std::string& latitude) {
    return "<trkpt lat=\"" + latitude + "\" lon=\"8.416\"><ele>116</ele><time>2011-09-26T13:02:" + second +
           "Z</time></trkpt>";
  };
  const auto reference = read(ReferenceFormat::kGpx, "a.gpx",
                              gpx(point("27", "49.013") + point("28", "49.014") + "</trkseg></trk><trk><trkseg>" +
                                  point("25", "49.011") + point("26", "49.012") + point("27", "49.099")));
  ASSERT_TRUE(reference) << reference.error().message;
  ASSERT_EQ(reference->fixes.size(), 4U);
  EXPECT_EQ(reference->counts.repeated, 1);
  for (std::size_t i = 1; i < 4; ++i) {
    EXPECT_EQ(reference->fixes[i].time_ns - reference->fixes[i - 1].time_ns, kSecond_ns);
    EXPECT_NEAR(reference->fixes[i].enu_m.y() - reference->fixes[i - 1].enu_m.y(), 111.2, 0.1);
  }
}

TEST_F(References, GpxWithoutHeightsIsRefusedWithWhatIsMissing) {
  const auto reference = read(ReferenceFormat::kGpx, "a.gpx",
                              gpx("<trkpt lat=\"49.011\" lon=\"8.416\"><time>2011-09-26T13:02:25Z</time></trkpt>"));
  ASSERT_FALSE(reference);
  EXPECT_THAT(reference.error().message, HasSubstr("1 of 1 points have no <ele>"));
}

TEST_F(References, GpxThatIsNoneIsRefused) {
  const auto cut = read(ReferenceFormat::kGpx, "a.gpx", "<gpx><trk><trkseg><trkpt lat=");
  ASSERT_FALSE(cut);
  EXPECT_EQ(cut.error().code, ErrorCode::kBadFormat);
  EXPECT_THAT(cut.error().message, HasSubstr("a.gpx"));
  EXPECT_FALSE(read(ReferenceFormat::kGpx, "b.gpx", "<kml/>"));
}

std::string oxts_row(double latitude, double accuracy_m) {
  std::string row = std::to_string(latitude) + " 8.416 116.4";
  for (int i = 3; i < 30; ++i) {
    row += i == 23 ? " " + std::to_string(accuracy_m) : " 0";
  }
  return row + "\n";
}

TEST_F(References, OxtsIsAFolderOfKittiRaw) {
  write("drive/oxts/timestamps.txt", "2011-09-26 13:02:25.594360375\n2011-09-26 13:02:25.604\n");
  write("drive/oxts/data/0000000000.txt", oxts_row(49.011, 0.05));
  write("drive/oxts/data/0000000001.txt", oxts_row(49.012, 0.0));
  for (const char* name : {"drive", "drive/oxts"}) {
    const auto reference = read_reference({ReferenceFormat::kOxts, folder_.path() / name, std::nullopt, 0});
    ASSERT_TRUE(reference) << reference.error().message;
    ASSERT_EQ(reference->fixes.size(), 2U);
    EXPECT_EQ(reference->fixes[0].time_ns, 1'317'042'145'594'360'375);
    EXPECT_NEAR(reference->fixes[0].sigma_m.x(), 0.05, 1e-12);
    EXPECT_NEAR(reference->fixes[1].sigma_m.x(), 0.01, 1e-12);
  }
}

TEST_F(References, OxtsThatIsCutIsRefusedWithFileAndLine) {
  write("drive/oxts/timestamps.txt", "2011-09-26 13:02:25.5\n2011-09-26 13:02\n");
  auto reference = read_reference({ReferenceFormat::kOxts, folder_.path() / "drive", std::nullopt, 0});
  ASSERT_FALSE(reference);
  EXPECT_THAT(reference.error().message, HasSubstr("timestamps.txt, line 2"));
  write("drive/oxts/timestamps.txt", "2011-09-26 13:02:25.5\n");
  EXPECT_EQ(read_reference({ReferenceFormat::kOxts, folder_.path() / "drive", std::nullopt, 0}).error().code,
            ErrorCode::kNotFound);
  write("drive/oxts/data/0000000000.txt", "49 8 116\n");
  EXPECT_EQ(read_reference({ReferenceFormat::kOxts, folder_.path() / "drive", std::nullopt, 0}).error().code,
            ErrorCode::kBadFormat);
  EXPECT_EQ(read_reference({ReferenceFormat::kOxts, folder_.path() / "none", std::nullopt, 0}).error().code,
            ErrorCode::kNotFound);
}

TEST_F(References, EurocIsInMetresAboutAnOrigin) {
  const auto path =
      write("gt.csv", "#timestamp [ns],x,y,z,qw,qx,qy,qz\n1403636579763555584,4.688,-1.786,0.783,1,0,0,0\n");
  const auto without = read_reference({ReferenceFormat::kEuroc, path, std::nullopt, 0});
  ASSERT_FALSE(without);
  EXPECT_EQ(without.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(without.error().message, HasSubstr("--origin"));
  const auto reference = read_reference({ReferenceFormat::kEuroc, path, Geodetic{47.4, 8.5, 450.0}, 0});
  ASSERT_TRUE(reference);
  EXPECT_EQ(reference->fixes[0].time_ns, 1403636579763555584);
  EXPECT_EQ(reference->fixes[0].enu_m, Eigen::Vector3d(4.688, -1.786, 0.783));
}

TEST_F(References, CsvHasItsColumnsByName) {
  const auto reference = read(ReferenceFormat::kCsv, "a.csv",
                              "height,timestamp_ns,latitude,longitude,sigma_up\n"
                              "116.4,1317042145594360375,49.011,8.416,0.4\n");
  ASSERT_TRUE(reference) << reference.error().message;
  EXPECT_EQ(reference->fixes[0].sigma_m, Eigen::Vector3d(3.0, 3.0, 0.4));
  const auto missing = read(ReferenceFormat::kCsv, "b.csv", "timestamp_ns,latitude,longitude\n1,2,3\n");
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().message, HasSubstr("'height' is missing"));
  for (const char* row : {"1,91,0,0", "1,nan,0,0", "1,0,0,1e9", "x,0,0,0"}) {
    EXPECT_FALSE(read(ReferenceFormat::kCsv, "c.csv", std::string("timestamp_ns,latitude,longitude,height\n") + row));
  }
}

TEST_F(References, RowsMayComeInAnyOrder) {
  const std::string header = "timestamp_ns,latitude,longitude,height\n";
  const auto row = [](const std::string& second, const std::string& height) {
    return second + "000000000,49.011,8.416," + height + "\n";
  };
  for (const std::string& rows : {row("4", "119") + row("3", "118") + row("2", "117") + row("1", "116"),
                                  row("3", "118") + row("1", "116") + row("4", "119") + row("2", "117")}) {
    const auto reference = read(ReferenceFormat::kCsv, "a.csv", header + rows);
    ASSERT_TRUE(reference) << reference.error().message;
    ASSERT_EQ(reference->fixes.size(), 4U);
    EXPECT_EQ(reference->counts.repeated, 0);
    for (std::size_t i = 1; i < 4; ++i) {
      EXPECT_EQ(reference->fixes[i].time_ns - reference->fixes[i - 1].time_ns, kSecond_ns);
      EXPECT_NEAR(reference->fixes[i].enu_m.z() - reference->fixes[i - 1].enu_m.z(), 1.0, 1e-6);
    }
  }
}

TEST_F(References, AWrongTimeCostsOneFix) {
  const auto reference = read(ReferenceFormat::kCsv, "a.csv",
                              "timestamp_ns,latitude,longitude,height\n"
                              "4000000000000000000,49,8.4,150\n"
                              "1000000000,49.011,8.416,116\n2000000000,49.011,8.416,116\n"
                              "3000000000,49.011,8.416,116\n");
  ASSERT_TRUE(reference) << reference.error().message;
  ASSERT_EQ(reference->fixes.size(), 4U);
  EXPECT_EQ(reference->fixes[0].time_ns, kSecond_ns);
  EXPECT_EQ(reference->counts.gaps, 1);
}

TEST_F(References, AnOriginFarAwayIsRefused) {
  const auto path = write("a.csv", "timestamp_ns,latitude,longitude,height\n1,49.011,8.416,116\n");
  for (const Geodetic& far : {Geodetic{0.0, 0.0, 0.0}, Geodetic{-49.0, 8.4, 0.0}, Geodetic{50.0, 8.416, 116.0}}) {
    const auto reference = read_reference({ReferenceFormat::kCsv, path, far, 0});
    ASSERT_FALSE(reference) << far.latitude_deg;
    EXPECT_EQ(reference.error().code, ErrorCode::kInvalidArgument);
    EXPECT_THAT(reference.error().message, HasSubstr("--origin lies "));
  }
  EXPECT_TRUE(read_reference({ReferenceFormat::kCsv, path, Geodetic{49.5, 8.416, 0.0}, 0}));
}

TEST_F(References, AWildFixDoesNotTiltTheMap) {
  std::string text = "timestamp_ns,latitude,longitude,height\n1000000000,0,0,0\n";
  for (int i = 2; i < 9; ++i) {
    text += std::to_string(i) + "000000000,49.011,8.416,116\n";
  }
  const auto reference = read(ReferenceFormat::kCsv, "a.csv", text);
  ASSERT_TRUE(reference);
  EXPECT_DOUBLE_EQ(reference->frame.origin().latitude_deg, 49.011);
}

}  // namespace
}  // namespace kinetrace::geo
