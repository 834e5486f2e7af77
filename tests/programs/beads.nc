% beads
; four frames and a field of dots; M160, M161 valve on and off, M200 pressure in mbar, M110 progress in per mille
N10 G90 G71 G94
N20 M200=1200
N30 M110=0
N40 #CONTOUR MODE [DEV PATH_DEV=0.08]
N50 G261
N60 F1200
$FOR P1 = 0, 3, 1
  N70 P2 = 20 * [P1 MOD 2]
  N80 P3 = 20 * INT[P1 / 2]
  N90 G00 X[P2] Y[P3]
  N100 Z0.6
  N110 M160
  N120 G01 X[P2+6]
  N130 Y[P3+6]
  N140 X[P2]
  N150 Y[P3]
  N160 M161
  N170 G00 Z5
  N180 M110 = 100 * [P1+1]
$ENDFOR
N190 G260
$FOR P4 = 0, 1, 1
  $FOR P5 = 0, 2, 1
    N200 G00 X[60+2*P4] Y[2*P5]
    N210 Z0.4
    N220 M162=30
    N230 Z1
  $ENDFOR
  N240 M110 = 500 + 50*[P4+1]
$ENDFOR
N250 #FLUSH WAIT
N260 #MSG ["dots done, X=%f Y=%f", V.A.ABS.X, V.A.ABS.Y]
N270 G00 Z50
N280 M30
