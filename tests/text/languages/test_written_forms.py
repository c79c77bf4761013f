"""Times, dates, ordinals, money, units, ranges, short forms and capitals, as each language says them."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import pytest

from mien.core.errors import InputError
from mien.text.languages import find_language, known_languages, read_in
from mien.text.languages.segmenting import note_on_blanks, segmented
from mien.text.languages.tokens import Token
from mien.text.languages.written_forms import spoken_tokens
from tests.programs import voice_or_skip

# What is written = what is said.
CASES = {
    "de": """
        um 7:30 Uhr = um sieben Uhr dreißig
        um 15.30 Uhr, 1 Uhr = um fünfzehn Uhr dreißig ein Uhr
        am 3.5.2024 = am dritten Mai zweitausendvierundzwanzig
        der 2. Mai 1984 = der zweite Mai neunzehnhundertvierundachtzig
        5,50 € und 1.000 km = fünf Euro fünfzig und eintausend Kilometer
        -5 °C, 5-7 Tage, 20 % = minus fünf Grad Celsius fünf bis sieben Tage zwanzig Prozent
        Ludwig XIV. und z. B. die ARD = Ludwig der vierzehnte und zum Beispiel die a. r. d.
        Er hat 3. Sie hat 1. = Er hat drei Sie hat eins
        die 2. Auflage und der 2. Mann im 4. Stock = die zweite Auflage und der zweite Mann im vierten Stock
        in der 2. Reihe, Ende der 1. Halbzeit = in der zweiten Reihe Ende der ersten Halbzeit
        das 5. Kind = das fünfte Kind
        Er nahm den 3. Dann aß er 5 Stk. = Er nahm den drei Dann aß er fünf Stück
        der 7:30-Zug, 1/2 Liter = der sieben Uhr dreißig Zug ein halb Liter
        +49 30 12345 = plus vier neun drei null eins zwei drei vier fünf
        """,
    "fr": """
        Au 06 12 34 56 78 = Au zéro six douze trente-quatre cinquante-six soixante-dix-huit
        +33 6 12 34 56 78 = plus trente-trois six douze trente-quatre cinquante-six soixante-dix-huit
        le 05/03/2024 = le cinq mars deux mille vingt-quatre
        à 15h30 ou 15 h 30 = à quinze heures trente ou quinze heures trente
        à 1h et à 21:00 = à une heure et à vingt-et-une heures
        le 1er mai et le 3/5/2024 = le premier mai et le trois mai deux mille vingt-quatre
        5,50 € à 80 km/h = cinq euros cinquante à quatre-vingts kilomètres heure
        la 2e fois, au XIXe siècle = la deuxième fois au dix-neuvième siècle
        3,14, -5 °C, la SNCF = trois virgule quatorze moins cinq degrés Celsius la s. n. c. f.
        M. Dupont, p. ex. = monsieur Dupont par exemple
        """,
    "es": """
        1 libro y 1 casa = un libro y una casa
        21 mujeres, 31 días = veintiuna mujeres treinta y un días
        500 personas en 2021 = quinientas personas en dos mil veintiuno
        a las 15:30 h = a las quince y treinta
        el 3/5/2024 = el tres de mayo de dos mil veinticuatro
        5,50 € y 1.000 km = cinco euros con cincuenta y mil kilómetros
        el 1.º, la 2ª, el 1er piso = el primero la segunda el primer piso
        21 casas, 200 casas, 21 libros = veintiuna casas doscientas casas veintiún libros
        Sr. López, EE. UU., Felipe VI, siglo XXI = señor López Estados Unidos Felipe sexto siglo veintiuno
        """,
    "it": """
        alle 15.30 e alle 1:00 = alle quindici e trenta e alle una
        il 3/5/2024 = il tre maggio duemilaventiquattro
        5,50 € e 20 °C = cinque euro e cinquanta e venti gradi Celsius
        1° maggio, 2ª volta, Sig. Rossi = primo maggio seconda volta signor Rossi
        """,
    "pt": """
        2 casas e 2 livros = duas casas e dois livros
        200 pessoas, 2 vezes, 2 dias = duzentas pessoas duas vezes dois dias
        às 15h30 = às quinze horas e trinta
        3/5/2024 = três de maio de dois mil e vinte e quatro
        R$ 5,50 e 2 £ = cinco reais e cinquenta e duas libras
        1.º lugar, 2ª vez, Sr. Silva = primeiro lugar segunda vez senhor Silva
        """,
    "nl": """
        om 7:30 uur = om zeven uur dertig
        3-5-2024 = drie mei tweeduizendvierentwintig
        € 5,50 en 20 % = vijf euro vijftig en twintig procent
        de 2e keer, d.w.z. = de tweede keer dat wil zeggen
        """,
    "sv": """
        kl. 7.30 den 3 maj = klockan sju trettio den tredje maj
        kl 7:05 år 1984 = klockan sju noll fem år nittonhundraåttiofyra
        1 kr och 5,50 kr = en krona och fem kronor och femtio
        5 st. och 1 st, st. Göran = fem stycken och ett styck sankt Göran
        1:a gången, t.ex. = första gången till exempel
        """,
    "pl": """
        o 7:30 = o siódmej trzydzieści
        3.05.2024 = trzeciego maja dwa tysiące dwadzieścia cztery
        1 zł, 22 zł, 5 zł = jeden złoty dwadzieścia dwa złote pięć złotych
        2. piętro, 2. klasa, XX wiek = drugie piętro druga klasa dwudziesty wiek
        np. 3,5 km i 2 min = na przykład trzy przecinek pięć kilometra i dwie minuty
        """,
    "cs": """
        v 7:30 = v sedm hodin třicet minut
        3.5.2024 = třetího května dva tisíce dvacet čtyři
        1 Kč, 3 Kč, 5 Kč = jedna koruna tři koruny pět korun
        2. patro, Karel IV., např. = druhé patro Karel čtvrtý například
        """,
    "ru": """
        в 7:30 = в семь часов тридцать минут
        03.05.2024 = третьего мая две тысячи двадцать четвертого года
        21 ₽, 2 мин, -5 °C = двадцать один рубль две минуты минус пять градусов Цельсия
        1-й, 5-я, XX век, т. е. = первый пятая двадцатый век то есть
        """,
    "el": """
        στις 7:30 = στις επτά και τριάντα
        3/5/2024 = τρεις Μαΐου δύο χιλιάδες είκοσι τέσσερα
        5,50 € και 2 £ = πέντε ευρώ και πενήντα και δύο λίρες
        2ος, 1η, κλπ. = δεύτερος πρώτη και λοιπά
        """,
    "tr": """
        saat 7:30 = saat yedi otuz
        3.5.2024 = üç Mayıs iki bin yirmi dört
        5,50 TL, %20, 80 km/h = beş lira elli yüzde yirmi saatte seksen kilometre
        2. kat, vb. = ikinci kat ve benzeri
        """,
    "fi": """
        klo 7.30 = kello seitsemän kolmekymmentä
        3.5.2024 = kolmas toukokuuta kaksituhattakaksikymmentäneljä
        1 €, 5,50 €, -5 °C = yksi euro viisi euroa viisikymmentä miinus viisi celsiusastetta
        2. kerros, Kaarle XII, esim. 20 % = toinen kerros Kaarle kahdestoista esimerkiksi kaksikymmentä prosenttia
        12 500 ja 3,05 = kaksitoistatuhattaviisisataa ja kolme pilkku nolla viisi
        """,
    "zh": """
        7:30，2024年5月3日 = 七点三十分 二零二四年五月三日
        今天5元的书，下午3点 = 今天 五 元的书 下午 三点
        他有5元,你走;好 = 他有 五 元 你走 好
        2个人，3.5公里，50% = 两 个人 三 点 五 公里 百分之五十
        """,
    "ja": """
        1匹 3匹 10匹 = いっぴき さんびき じゅっぴき
        8冊 20枚 3階 6個 = はっさつ にじゅうまい さんがい ろっこ
        2024年 3年間 20日 = にせんにじゅうよねん さんねんかん はつか
        3時間 3時 1ヶ月 20歳 = さんじかん さんじ いっかげつ はたち
        7:30に、15時30分に = しちじ さんじゅっぷん に じゅうごじ さんじゅっぷん に
        今日は7時30分に = 今日は しちじ さんじゅっぷん に
        3人と1人と2人、1つ、3本、10分 = さんにん と ひとり と ふたり ひとつ さんぼん じゅっぷん
        11人、20本、100本、1000本、人、3分の1 = じゅういちにん にじゅっぽん ひゃっぽん せんぼん 人 さん 分の いち
        2024年5月3日、300円 = にせんにじゅうよんねん ごがつ みっか さんびゃく えん
        """,
}  # fmt: skip


def test_every_language_has_cases() -> None:
    assert set(CASES) == set(known_languages())


@pytest.mark.parametrize(
    ("tag", "written", "said"),
    [(tag, *line.strip().split(" = ")) for tag, lines in CASES.items() for line in lines.strip().splitlines()],
)
def test_figures_signs_and_short_forms(tag: str, written: str, said: str) -> None:
    language = find_language(tag)
    assert language is not None
    assert " ".join(token.said or token.text for token in spoken_tokens(written, language)) == said


def test_marks_between_chinese_characters_pause_whatever_their_width() -> None:
    chinese = find_language("zh")
    assert chinese is not None
    narrow, wide = (
        [(t.text, t.pause) for t in spoken_tokens(text, chinese)] for text in ("我来了,你走;好", "我来了，你走；好")
    )
    assert narrow == wide == [("我来了", ","), ("你走", ";"), ("好", "")]


def test_a_rule_that_no_language_has_is_named(tmp_path: Path) -> None:
    table = tmp_path / "uk.toml"
    table.write_text(
        'tag = "uk"\nname = "Ukrainian"\nreader = "espeak"\nespeak = "uk"\n[written]\nclock = "{h:cardinal-femnine}"\n'
    )
    language = find_language(table)
    assert language is not None
    with pytest.raises(InputError, match="did you mean 'cardinal-feminine'"):
        list(spoken_tokens("7:00", language))


def test_words_know_their_place_and_the_sentence_its_end() -> None:
    voice_or_skip("espeak-de")
    german = find_language("de")
    assert german is not None
    said = read_in(german, "Um 7:30 Uhr (z.B.) am 3.5.")
    assert [said.written[word.start : word.end] for word in said.words] == [
        "Um", *["7:30 Uhr"] * 3, *["z.B."] * 2, "am", *["3.5."] * 2,
    ]  # fmt: skip
    assert said.words[-1].pause == "."


@pytest.mark.skipif(find_spec("rjieba") is None, reason="rjieba is not installed")
def test_chinese_without_blanks_is_cut_into_words() -> None:
    chinese = find_language("zh")
    assert chinese is not None
    parts = list(segmented(Token("我们去北京", 3, 8, "."), chinese))
    assert [(part.text, part.start, part.end, part.pause) for part in parts] == [
        ("我们", 3, 5, ""), ("去", 5, 6, ""), ("北京", 6, 8, "."),
    ]  # fmt: skip


@pytest.mark.skipif(find_spec("janome") is None, reason="Janome is not installed")
def test_japanese_is_read_with_its_particles() -> None:
    japanese = find_language("ja")
    assert japanese is not None
    said = [part.said for part in segmented(Token("今日は東京へ行きました", 0, 11), japanese)]
    assert said == ["キョーワ", "トーキョーエ", "イキマシタ"]


def test_without_a_segmenter_particles_are_known_and_a_long_clause_is_a_note(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mien.text.languages.segmenting.find_spec", lambda name: None)
    japanese, chinese = find_language("ja"), find_language("zh")
    assert japanese is not None
    assert chinese is not None
    said = [next(segmented(Token(word, 0, len(word)), japanese)).said for word in ("わたしは", "ふじさんへ", "はは")]
    assert said == ["わたしわ", "ふじさんえ", ""]
    (note,) = note_on_blanks(["今天天气很好"], chinese)
    assert 'pip install "mien[zh]"' in note.message
    assert not note_on_blanks(["今天"], chinese)
