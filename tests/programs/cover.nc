(Cover 60 x 40: two helical pockets, a row of pecked holes with a counter, an engraved outline with round corners)
(Zero point: front left corner, top face. Programmed on the cutter's centre line.)
%L POCKET
(P10 P11 centre, P12 path radius, P13 depth, P14 depth per turn)
N10 G00 X[P10 + P12] Y[P11]
N20 Z1
N30 G01 Z0 F1200
N40 P15 = 0
N50 $WHILE P15 < P13
N60   P15 = P15 + P14
N70   $IF P15 > P13
N80     P15 = P13
N90   $ENDIF
N100  G02 X[P10 + P12] Y[P11] Z[-P15] I[-P12] J0 F3000
N110 $ENDWHILE
N120 G02 I[-P12] (clean turn)
N130 G01 X[P10] F3000
N140 G00 Z4
N150 M17

%L OUTLINE
(P20 width, P21 height, P22 corner radius, in increments from the lower left straight)
N10 G91 G01 X[P20 - 2 * P22] F4000
N20 G03 X[P22] Y[P22] R[P22]
N30 G01 Y[P21 - 2 * P22]
N40 G03 X[-P22] Y[P22] R[P22]
N50 G01 X[-[P20 - 2 * P22]]
N60 G03 X[-P22] Y[-P22] R[P22]
N70 G01 Y[-[P21 - 2 * P22]]
N80 G03 X[P22] Y[-P22] R[P22]
N90 G90
N100 M29

%COVER
N10 G17 G90 G71 G94 G162
N20 M20 (close the clamp)
N30 T1 M6
N40 S3000 M3
N50 M8
N60 G00 G54 X0 Y0 Z10
N70 P12 = 5  P13 = 3.5  P14 = 1.5
N80 $FOR P10 = 15, 45, 30
N90   P11 = 20
N100  LL POCKET
N110 $ENDFOR
N120 M9
N130 T2 M6
N140 S4000 M3 M8
N150 $FOR P1 = 0, 7, 1
N160   G00 X[6 + P1 * 48 / 7] Y[5 + SIN[P1 * 45]]
N170   Z1
N180   $FOR P2 = 1, 2, 1
N190     G01 Z[-2 * P2] F1500
N200     G04 0.05
N210     G00 Z[-2 * P2 + 0.5]
N220   $ENDFOR
N230   G00 Z3 H12=[P1 + 1] (counts the holes)
N240 $ENDFOR
N250 M9
N260 T3 M6
N270 S5000 M3
N280 $FOR P3 = 1, 2, 1
N290   G00 X8 Y3
N300   G01 Z[-0.2 * P3] F1500
N310   P20 = 54  P21 = 34  P22 = 5
N320   LL OUTLINE
N330   G00 Z2
N340 $ENDFOR
N350 G00 Z20
N360 M5
N370 M21 (open the clamp)
N380 M30
