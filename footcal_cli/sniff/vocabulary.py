"""Words in names of columns, and what each of them says.

Room: sniff; asked by names.
"""

from __future__ import annotations

import re
import unicodedata
from typing import Literal

Quantity = Literal[
    "time", "sequence", "load", "reading", "force", "cop", "quaternion", "angle", "matrix",
    "gravity", "acceleration", "com", "com_acc", "foot_position", "hole", "temperature", "label",
    "direction", "repeat", "session", "phase", "orientation", "placement", "contact", "pressure",
    "position", "motion", "other", "unknown",
]  # fmt: skip

WORDS: dict[str, Quantity] = {}
_SPELLINGS: dict[Quantity, str] = {
    "time": "time zeit timestamp stamp temps tiempo tempo t secs seconds millis micros elapsed "
    "minutes minuten minuti minutos minuter minutter minuty hours stunden heures horas sekunden "
    "uhrzeit clock date datetime datum date_time zeitstempel tid czas timer timestep время дата "
    "时间 時間 时刻 jikoku jikan aika aeg čas czas zaman idő vrijeme vreme timp laikas χρόνος",
    "sequence": "seq sample index idx frame frames nr no number id row record counter packet n "
    "subframe sub messung probe nummer posture haltung stellung junban bangou "
    "paso pasos schritt etapa étape amostra muestra échantillon campione próbka vzorek näyte",
    "load": "load weight mass masse gewicht last poids charge peso carga applied known reference "
    "ref true nominal referenz belastung soll target gewichte weights loads std standard setpoint "
    "gross net brutto netto lordo bruto neto added increment zugelegt "
    "kraft_soll ounce ounces gram grams gramm kilogram pound pounds vikt pesa pesas pesata "
    "fundou omori vekt vægt lodd lod lodder gewichten waga závažia súly "
    "hmotnost závaží zatížení masa ciężar obciążenie odważnik tömeg terhelés ağırlık "
    "agirlik kütle kutle kuorma paino punnus "
    "massa appliqué appliquée aplicada "
    "carico put aufgelegt масса вес нагрузка груз эталон 质量 重量 载荷 负载 砝码 荷重 荷重",
    "reading": "reading readings counts count raw adc value val signal output fsr cell loadcell "
    "volt volts voltage spannung messwert wert hx taxel bits lsb data sensor scale strain bridge "
    "lc ain analog a channel ch kanal zelle medida mesure valeur lectura cap capacitance lecture "
    "denatsu voltaje voltaggio "
    "visning avläsning avlesning aflezing uitlezing lukema affichage leitura indicación "
    "snímač snimac buňka anturi czujnik hücre hucre sensore sensör érzékelő givare opnemer čtení "
    "hodnota odečet údaj výstup odczyt wskazanie leolvasás okuma ölçüm näyttö "
    "cells loadcells brut brute lettura valore anzeige rohwert rohwerte zählwert ausgabe display "
    "отсчёт отсчет ацп датчик код показание показания 读数 读值 示数 传感器 电压 値 值 出力",
    "temperature": "temp temperature temperatur température temperatura ondo amb ambient "
    "lämpötila lampotila teplota temperatuur hőmérséklet homerseklet sıcaklık sicaklik suhu hiti "
    "temperatură thermokrasia θερμοκρασία температура 温度",
    "label": "cell channel sensor zelle kanal foot fuss leg bein device name side location bein",
    "direction": "direction dir richtung updown way",
    "repeat": "repeat rep repetition trial run cycle durchgang wiederholung essai lauf prova "
    "series serie reihe messreihe série round runde zyklus ciclo ronda vuelta pasada cycles tour "
    "tornata giro repetición repeticion pass kaisu volta voltas rodada repetição repeticao varv "
    "omgång omgang ronde omloop herhaling kierros toisto ripetizione okrążenie kai "
    "řada série opakování sarja seria sorozat ismétlés powtórzenie tekrar 回数 轮次 周回",
    "session": "session day tag set block sitzung",
    "phase": "phase shaft crank winkel drehwinkel kurbelwinkel fase fázis fáze faza vaihe fas "
    "angolo angulo ángulo ângulo hoek vinkel kulma kąt úhel açı góc goc фаза угол 角度 相位 "
    "位相",
    "orientation": "orientation lage attitude ori orientacion orientación orientação orientamento",
    "placement": "placement hole point position loch punkt place spot pose bohrung bohrloch trou "
    "agujero orificio foro furo buraco punto ponto stelle hål hul gat otwór otwor ana",
    "contact": "contact kontakt stance temas chạm cham",
    "pressure": "pressure druck pression",
    "other": "humidity feuchte luftfeuchte feuchtigkeit humedad "
    "status state flag error err battery batt dropout valid quality rssi crc checksum "
    "comment remark note notiz bemerkung units unit einheit weg displacement stroke travel "
    "tracking min max peak tare tara validity throttle pwm duty pct percent rpm efficiency esc",
}
for _meaning, _spellings in _SPELLINGS.items():
    for _word in _spellings.split():
        WORDS.setdefault(_word, _meaning)

MARKED = {word for word, meant in WORDS.items() if meant == "placement"} - {"pose"}
MARKED |= {"pos", "position", "target", "ref", "true", "mark"}
"""What the x and y of a hole are called by."""
SCATTER = {
    "stdev", "stddev", "sdev", "stdabw", "standardabweichung", "streuung", "écarttype",
    "ecarttype", "desv", "desvest", "desviación", "desviacion", "desvio", "deviazione", "odchylka",
    "odchylenie", "keskihajonta", "hajonta", "standardavvik", "standardavvikelse",
    "standaardafwijking", "szórás", "scatter", "sigma", "标准差", "標準偏差",
}  # fmt: skip
"""Words for a standard deviation, whatever stands around them."""
NUMBERS = {"no", "nr", "num", "number", "nummer", "numero", "número", "numéro", "bangou", "id"}
"""What a name says that counts things: ``cell no``, ``Zelle Nr``."""
COUNTED = ("ch", "chan", "kanal", "canal")
"""A small whole number that is called so says of which channel a row is. Groups of rows below a
title are called ``channel`` whatever they are of, so that this word alone says less."""
OF_A_ROW = {*COUNTED, "channel", "sensor", "cell", "zelle", "celda", "cella", "cellule", "capteur",
            "celle", "cel", "célula", "celula",
            "snímač", "snimac", "buňka", "anturi", "czujnik", "hücre", "hucre", "sensore", "sensör",
            "érzékelő", "givare", "opnemer", "датчик"}  # fmt: skip
"""Names of columns that say which channel a row is of, if a few whole numbers take turns there."""
_CENTRE_OF = r"\bcent(?:er|re|ro)[\W_]*(?:of|de la|della|des?|di|do|du)?[\W_]*"
SAID_OTHERWISE = tuple(
    (re.compile(phrase, re.IGNORECASE), said) for phrase, said in (
        (rf"{_CENTRE_OF}(?:pressure|pression[e]?|presi[oó]n|press[aã]o)(?![^\W_])"
         r"|(?<![^\W_])druck(?:mittel)?punkt", "cop"),
        (rf"{_CENTRE_OF}(?:mass[ae]?|masas?|gravity|gravité|gravedad|gravidade|gravità)(?![^\W_])"
         r"|(?<![^\W_])(?:(?:massen)?(?:schwer|mittel)punkt|baricentro|barycentre|cdm|cdg|juushin|"
         r"cog(?=[\W_]?[xyz](?![^\W_])))", "com"),
        (r"com(?=[xyz](?![^\W_]))", "com"), (r"foot(?=[xyz](?![^\W_]))", "foot"),
        (r"(?<![^\W_])(?:pie|pied|piede|fuß|fuss|voet)(?![^\W\d_])", "foot"),
    )
)  # fmt: skip
"""Phrases and words of other languages -> the word that is looked for."""
EAST_ASIAN = {
    "左脚": "left foot", "右脚": "right foot", "左足": "left foot", "右足": "right foot",
    **{a + b: f"{x}{y}" for a, x in (("前", "f"), ("后", "r"), ("後", "r"))
       for b, y in (("左", "l"), ("右", "r"))},
    **{b + a: f"{x}{y}" for a, x in (("前", "f"), ("后", "r"), ("後", "r"))
       for b, y in (("左", "l"), ("右", "r"))},
    "质心": "com", "質心": "com", "重心": "com", "加速度": "acc", "位置": "position",
}  # fmt: skip
"""Feet, places on them and the centre of mass, as Chinese and Japanese names write them."""

PLACES = {
    "fl": "fl", "fr": "fr", "rl": "rl", "rr": "rr", "bl": "rl", "br": "rr", "hl": "hl", "hr": "hr",
    "ml": "ml", "mr": "mr", "lf": "fl", "rf": "fr", "lh": "hl", "rh": "hr", "lb": "rl", "rb": "rr",
    "lm": "ml", "rm": "mr", "lr": "rl",
}  # fmt: skip
ENDS = {"front": "f", "fore": "f", "rear": "r", "back": "r", "hind": "h", "middle": "m",
         "mid": "m", "vorne": "f", "hinten": "r", "vorn": "f", "mitte": "m", "avant": "f",
         "arrière": "r", "arriere": "r", "milieu": "m", "av": "f", "ar": "r", "anteriore": "f",
         "posteriore": "r", "mae": "f", "ushiro": "r", "delantera": "f", "delantero": "f",
         "trasera": "r", "trasero": "r",
         "dianteiro": "f", "traseiro": "r", "voor": "f", "achter": "r", "fram": "f", "bak": "r",
         "передняя": "f", "задняя": "r"}  # fmt: skip
BEHIND_AN_END = {"g": "left", "d": "right"}
"""Sides by one letter behind an end of a foot, in French: AvG, ArD."""
WITH_A_LEG = {"sx": "left", "dx": "right", "sol": "left", "sağ": "right", "sag": "right",
           "bal": "left", "jobb": "right"}  # fmt: skip
OF_A_LEG = {"piede", "piedi", "foot", "gamba", "zampa", "suola", "cella", "anteriore",
             "posteriore", "ayak", "taban", "bacak", "láb", "lab", "talp"}  # fmt: skip
"""Words with which dx is a side and no change of x, and sol is left and no ground."""
SOLES = {"sole", "sohle", "suola", "semelle", "suela", "zool", "såle", "sula", "podeszwa", "stopa",
         "taban", "ayak", "talp", "láb", "lab", "jalka", "jalkapohja", "noha", "fot", "fod",
         "стопа", "подошва"}  # fmt: skip
"""How the pose of a foot's sole is called."""
SIDES = {"left": "left", "l": "left", "links": "left", "right": "right", "r": "right",
          "rechts": "right", "lfoot": "left", "rfoot": "right", "gauche": "left",
          "droite": "right", "droit": "right", "izq": "left", "der": "right", "li": "left",
          "re": "right", "lt": "left", "rt": "right", "ftl": "left",
          "ftr": "right", "footl": "left", "footr": "right",
          "lleg": "left", "rleg": "right", "ll": "left",
          **dict.fromkeys(("linke", "linker", "linkes", "izquierda", "izquierdo", "sinistra",
                           "sinistro", "esquerda", "esquerdo", "vänster", "venstre", "левая",
                           "левый", "hidari", "izda", "lewa", "lewy", "lewe", "vasen", "vasemman",
                           "levá", "levý", "levé", "leva", "levy", "leve", "ľavá", "ľavý",
                           "lijeva", "lijevi", "ліва", "лівий", "vänstra", "stânga", "stanga",
                           "αριστερό", "trái", "trai"), "left"),
          **dict.fromkeys(("rechte", "rechter", "rechtes", "derecha", "derecho", "destra",
                           "destro", "direita", "direito", "höger", "højre", "правая",
                           "правый", "migi", "dcha", "prawa", "prawy", "prawe", "oikea", "oikean",
                           "pravá", "pravý", "pravé", "prava", "pravy", "prave", "desna", "desni",
                           "права", "правий", "högra", "høyre", "dreapta", "δεξί", "phải",
                           "phai"), "right")}  # fmt: skip
DIRECTIONS = {
    word: sign
    for sign, spellings in {
        "1": "up loading load increasing inc ascending asc rising auf aufwärts aufwaerts hoch "
        "belasten belastung steigend subida subiendo carga cargando montée montee charge salita "
        "carico salendo subindo carregando omhoog opp upp вверх нагружение 加载 載荷 加載",
        "-1": "down unloading unload decreasing dec descending desc falling ab abwärts abwaerts "
        "runter entlasten entlastung fallend bajada bajando descarga descargando descente décharge "
        "decharge discesa scarico scendendo descida descarregando omlaag ned вниз разгружение 卸载 "
        "除荷 卸載",
    }.items()
    for word in spellings.split()
}
"""Whether weights are put on or taken off, in words -> a recipe's direction."""
LETTERS = ({"u": "1", "d": "-1"}, {"i": "1", "d": "-1"})
"""The same by one letter: up and down, increasing and decreasing."""
LEGS = {"leg", "legs", "limb", "bein", "beine", "fuss", "fuß", "foot", "pata", "pierna", "patte",
        "jambe", "gamba", "zampa", "perna", "poot", "noga", "нога", "足", "脚", "腿"}  # fmt: skip
"""How a column is called that says of which leg a row is."""
ANGLES = {
    word: axis
    for axis, spellings in {
        "roll": "roll bank rollwinkel wankwinkel rollen wanken wank roulis alabeo balanceo rollio "
        "rolamento rolagem rolado rotolamento krängning krengning kallistus przechylenie "
        "yalpa yuvarlanma крен 横滚角 横滚 ロール角 ロール",
        "pitch": "pitch elevation nickwinkel nicken nick tangage cabeceo beccheggio arfagem "
        "pochylenie stampning "
        "yunuslama тангаж 俯仰角 俯仰 ピッチ角 ピッチ",
        "yaw": "yaw heading gierwinkel gieren gier lacet guiñada guinada imbardata "
        "odchylenie girning "
        "sapma рыскание 偏航角 偏航 ヨー角 ヨー",
    }.items()
    for word in spellings.split()
}
"""How the angles about x, y and z of a body are called."""
NOT_OF_CELLS = {
    "acc", "accel", "gyro", "gyr", "gyroscope", "imu", "mag", "magnetometer", "ang", "angvel",
    "velocity", "emg", "ecg", "acceleration", "speed", "distance", "extension", "elongation",
    "covariance", "cov",
}  # fmt: skip
"""Words for what no load cell reads: of an IMU, of muscles, of distances."""


_AS_ASCII = (
    str.maketrans({"ø": "oe", "ö": "oe", "ä": "ae", "æ": "ae", "å": "aa", "ü": "ue", "ß": "ss"}),
    str.maketrans("øöäåüłđı", "ooaauldi"),
)
_SHORTEST = 4


def _plainly(words: dict[str, str]) -> None:
    """Add what keyboards without a language's letters write: ``hoejre`` and ``hojre``, højre."""
    for word, said in [*words.items()]:
        for letters in _AS_ASCII:
            parts = unicodedata.normalize(
                "NFD", unicodedata.normalize("NFC", word).translate(letters)
            )
            plain = "".join(c for c in parts if not unicodedata.combining(c))
            if len(plain) >= _SHORTEST and plain.isascii():
                words.setdefault(plain, said)


for _words in (WORDS, SIDES, ENDS, ANGLES):
    _plainly(_words)  # type: ignore[arg-type]
