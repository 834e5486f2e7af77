%O0100(CLAMP PLATE)
(A plate 120 x 80 in the NCT dialect: frame, ring of notches, star. Zero point: front left corner, top face.)
N10 G17 G21 G90 G94
N20 M20 (clamp)
N30 T1
N35 M6
N40 S9000 M3
N50 G0 X-8 Y-8 Z20
N60 M8
(frame with rounded corners, in three passes)
N70 Z1
N80 M98 P101 L3
N90 G0 Z20
(six notches around the middle: there the incremental radius has its pole)
N100 G0 X60 Y40
N110 G16 XI0 Y0 (angles count from 0)
N120 M98 P102 L6
N130 G15
(a star of lines by their angles)
N140 X45 Y40 Z2
N150 G1 Z-0.5 F600
N160 X60 ,A60 F1800
N170 X75 ,A-60
N180 X45
N190 G0 Z20
N200 M9
N210 M5
N220 M30
%
%O0101(PASS OF FRAME)
G91 G1 Z-2 F600
G90 X-4 F4000
Y84 ,R12
X124 ,R12
Y-4 ,R12
X-4 ,C6
Y8
G0 X-8
Y-8
M99
%
%O0102(NOTCH)
G91 G0 X25 Y60
Z-18
G1 Z-3 F600
G0 Z21
X-25 Y0
G90
M99
%
